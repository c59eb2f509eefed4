#!/usr/bin/env python3
"""tandem-server as a process: what it prints, records, and says when its disk fails.

    python3 tests/server/program_test.py --bin build/release/bin

Every wait is bounded; only processes started here are ended.
"""
import argparse
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parent.parent.parent / "assets" / "scenes" / "peg_board.glb"
DISK_LIMIT = 4096  # bytes a file, when the disk is to fail


def wait_for(condition, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("timed out waiting until " + what)


class Server:
    def __init__(self, program, folder, *options):
        folder.mkdir(exist_ok=True)
        self.out, self.err = folder / "out", folder / "err"
        # restore_signals=False: Python ignores SIGXFSZ, and so shall the server, so that a write fails
        # instead.
        self.process = subprocess.Popen(
            [program, SCENE, "--listen", "127.0.0.1:0", "--data", folder / "data", *options],
            stdout=open(self.out, "w"), stderr=open(self.err, "w"), restore_signals=False)

    def links(self, role):
        return [line.split()[1] for line in self.out.read_text().splitlines() if line.startswith(role + " ")]

    def started(self):
        wait_for(lambda: self.process.poll() is not None or len(self.links("observer")) > 0,
                 "links are printed")
        assert self.process.poll() is None, self.err.read_text()

    def stop(self):
        self.process.terminate()
        return self.process.wait(20)


def an_expired_link_is_replaced(program, folder):
    server = Server(program, folder, "--token-lifetime", "1", "--invite", "instructor=0")
    try:
        server.started()
        wait_for(lambda: len(set(server.links("observer"))) >= 2, "a new link is printed")
        assert server.links("instructor") == []
    finally:
        code = server.stop()
    assert code == 0, code


def a_recording_is_begun_and_an_orderly_end_is_silent(program, folder):
    server = Server(program, folder, "--quiet", "--record", folder / "recording")
    try:
        server.started()
        wait_for(lambda: (folder / "recording").stat().st_size > 0, "the recording has its header")
    finally:
        code = server.stop()
    assert code == 0, code
    assert server.err.read_text() == "", server.err.read_text()


def a_recording_is_kept_when_the_same_command_is_given_again(program, folder):
    sizes = []
    for name in ("session.tandem", "session-2.tandem"):
        server = Server(program, folder, "--record", folder / "session.tandem")
        try:
            server.started()
            wait_for(lambda: (folder / name).stat().st_size > 0, "the recording has its header")
            with open(folder / name, "ab") as recording:
                recording.write(bytes(1000))  # stands for what a session records
        finally:
            code = server.stop()
        assert code == 0, code
        sizes.append((folder / "session.tandem").stat().st_size)
    assert sizes[0] == sizes[1] > 1000, sizes
    assert "session-2.tandem" in server.err.read_text(), server.err.read_text()


def wrong_numbers_of_places_are_refused_in_one_line(program, folder):
    folder.mkdir()
    for options in (["--max-participants", "0"], ["--max-participants", "1024"], ["--max-participants", "x"],
                    ["--max-observers", "-1"], ["--max-observers", "1.5"], ["--max-observers", "960"],
                    ["--max-participants", "1000", "--max-observers", "24"]):
        done = subprocess.run([program, SCENE, "--data", folder / "data", *options], capture_output=True,
                              text=True, timeout=20)
        assert done.returncode == 2 and done.stdout == "", (options, done)
        assert len(done.stderr.splitlines()) == 1 and options[-2] in done.stderr, (options, done.stderr)
    text = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=20).stdout
    assert "--max-participants" in text and "--max-observers" in text, text


def a_failing_disk_is_told_with_quiet_too(program, folder):
    server = Server(program, folder, "--quiet")
    try:
        server.started()
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (DISK_LIMIT, DISK_LIMIT))
        wait_for(lambda: "journal" in server.err.read_text(), "the failure is told")
    finally:
        code = server.stop()
    assert code == 1, code
    lines = server.err.read_text().splitlines()
    assert len(lines) == 1 and " error " in lines[0] and "session.db" in lines[0], lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    program = parser.parse_args().bin / "tandem-server"
    for test in (an_expired_link_is_replaced, a_recording_is_begun_and_an_orderly_end_is_silent,
                 a_recording_is_kept_when_the_same_command_is_given_again,
                 wrong_numbers_of_places_are_refused_in_one_line,
                 a_failing_disk_is_told_with_quiet_too):
        with tempfile.TemporaryDirectory() as folder:
            test(program, pathlib.Path(folder) / "server")
        print("ok", test.__name__, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
