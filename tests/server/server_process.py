"""tandem-server and tandem join as processes, for the tests beside this file.

Every wait is bounded; only processes started here are ended.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCENE = ROOT / "assets" / "scenes" / "peg_board.glb"


def wait_for(condition, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError("timed out waiting until " + what)


class Server:
    """A server on a free port. As a context it is ready inside, and stopped afterwards. `under`: a command
    that becomes the server."""

    def __init__(self, binaries, folder, *options, listen="127.0.0.1:0", environment=None,
                 under=()):
        folder.mkdir(exist_ok=True)
        self.program, self.data = binaries / "tandem-server", folder / "data"
        self.out, self.err = folder / "out", folder / "err"
        self.code = None  # once it has ended
        # restore_signals=False: Python ignores SIGXFSZ, and so shall the server, so that a write fails
        # instead.
        self.process = subprocess.Popen(
            [*under, self.program, SCENE, "--listen", listen, "--data", self.data, *options],
            stdout=open(self.out, "w"), stderr=open(self.err, "w"), restore_signals=False,
            env=dict(os.environ, **(environment or {})))

    def __enter__(self):
        try:
            wait_for(lambda: self.process.poll() is not None or len(self.links("observer")) > 0,
                     "links are printed")
            assert self.process.poll() is None, self.log()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self):
        self.process.terminate()
        self.code = self.process.wait(20)

    def log(self):
        return self.err.read_text()

    def links(self, role):
        return [line.split()[1] for line in self.out.read_text().splitlines() if line.startswith(role + " ")]

    def port(self):
        return re.search(r":(\d+)[/?]", self.links("observer")[0]).group(1)

    def order(self, *words):
        done = subprocess.run([self.program, "--data", self.data, *words], capture_output=True, text=True,
                              timeout=20)
        return done.returncode, done.stdout.strip(), done.stderr.strip()

    def audit(self):
        code, out, error = self.order("--audit", "--json")
        assert code == 0, error
        return [json.loads(line) for line in out.splitlines()]

    def events(self):
        return [row["event"] for row in self.audit()]


class Site:
    """A headless site. As a context it is ended afterwards."""

    def __init__(self, binaries, folder, link, name):
        self.path = folder / "site.log"
        self.process = subprocess.Popen(
            [binaries / "tandem", "join", link, "--headless", "--name", name, "--duration", "60"],
            stdout=open(self.path, "w"), stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            env=dict(os.environ, XDG_CACHE_HOME=str(folder / "cache")))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait(20)

    def log(self):
        return self.path.read_text()


def run(*tests):
    """Runs each test with the folder of the programs and a folder of its own."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    binaries = parser.parse_args().bin
    for test in tests:
        with tempfile.TemporaryDirectory() as folder:
            test(binaries, pathlib.Path(folder) / "server")
        print("ok", test.__name__, flush=True)
    return 0
