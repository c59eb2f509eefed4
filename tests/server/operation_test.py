#!/usr/bin/env python3
"""What an operator has of a running tandem-server: orders, the audit table, the log, the service manager.

    python3 tests/server/operation_test.py --bin build/release/bin

Every wait is bounded; only processes started here are ended.
"""
import argparse
import json
import os
import pathlib
import re
import socket
import stat
import subprocess
import sys
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parent.parent.parent / "assets" / "scenes" / "peg_board.glb"


def wait_for(condition, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError("timed out waiting until " + what)


class Server:
    def __init__(self, binaries, folder, *options, environment=None):
        folder.mkdir(exist_ok=True)
        self.program, self.data = binaries / "tandem-server", folder / "data"
        self.out, self.err = folder / "out", folder / "err"
        self.process = subprocess.Popen(
            [self.program, SCENE, "--listen", "127.0.0.1:0", "--data", self.data, *options],
            stdout=open(self.out, "w"), stderr=open(self.err, "w"),
            env=dict(os.environ, **(environment or {})))

    def __enter__(self):
        wait_for(lambda: self.process.poll() is not None or len(self.links("observer")) > 0,
                 "links are printed")
        assert self.process.poll() is None, self.err.read_text()
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(20)

    def links(self, role):
        return [line.split()[1] for line in self.out.read_text().splitlines() if line.startswith(role + " ")]

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
    def __init__(self, binaries, folder, link, name):
        self.log = folder / (name + ".log")
        self.process = subprocess.Popen(
            [binaries / "tandem", "join", link, "--headless", "--name", name, "--duration", "60"],
            stdout=open(self.log, "w"), stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            env=dict(os.environ, XDG_CACHE_HOME=str(folder / "cache")))

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
        return self.process.wait(20)


def orders_reach_a_running_server(binaries, folder):
    with Server(binaries, folder) as server:
        assert stat.S_IMODE(os.stat(server.data / "control.sock").st_mode) == 0o600
        ben = Site(binaries, folder, server.links("participant")[0], "Ben")
        try:
            wait_for(lambda: "joined" in server.events(), "Ben is in the audit table")
            code, _, error = server.order("--kick", "Eve")
            assert code == 1 and "Eve" in error, (code, error)
            code, out, error = server.order("--rotate-keys")
            assert code == 0 and "1 connected site has a new ticket" in out, (out, error)
            code, out, _ = server.order("--kick", "Ben", "--ban")
            assert code == 0 and "banned" in out, out
            wait_for(lambda: ben.process.poll() is not None, "the site that is banned ends")
            assert "operator" in ben.log.read_text(), ben.log.read_text()
        finally:
            ben.end()
        before = server.links("observer")
        code, _, _ = server.order("--revoke-links")
        assert code == 0
        wait_for(lambda: len(server.links("observer")) > len(before), "new links are printed")
        code, link, _ = server.order("--invite-now", "instructor")
        assert code == 0 and link.startswith("tandem://"), link
        row = next(row for row in server.audit() if row["event"] == "joined")
        assert row["name"] == "Ben" and row["role"] == "participant", row
        assert re.fullmatch(r"127\.0\.0\.1:\d+", row["address"]), row
        wait_for(lambda: "invited" in server.events(), "the last order is in the table")
        expected = ["joined", "keys rotated", "banned", "links revoked", "invited"]
        assert server.events() == expected, server.events()
    code, _, error = server.order("--kick", "Ben")
    assert code == 2 and "no server runs here" in error, (code, error)
    assert server.events() == expected, "the table is there without a server too"
    assert not (server.data / "control.sock").exists()


def keys_and_bans_outlive_a_restart(binaries, folder):
    with Server(binaries, folder) as server:
        old = server.links("participant")[0]
        assert server.order("--revoke-links")[0] == 0
    with Server(binaries, folder) as server:
        eve = Site(binaries, folder, re.sub(r":\d+(?=[/?])", ":" + port_of(server), old, count=1), "Eve")
        code = eve.process.wait(30)
        assert code != 0 and "not signed by this server" in eve.log.read_text(), eve.log.read_text()
        wait_for(lambda: "refused" in server.events(), "the refusal is in the table")


def port_of(server):
    return re.search(r":(\d+)[/?]", server.links("observer")[0]).group(1)


def the_log_is_json_that_names_session_and_site(binaries, folder):
    with Server(binaries, folder, "--log", "json") as server:
        ada = Site(binaries, folder, server.links("instructor")[0], "Ada")
        try:
            wait_for(lambda: "Ada" in server.err.read_text(), "Ada is logged")
        finally:
            ada.end()
    lines = [json.loads(line) for line in server.err.read_text().splitlines()]
    joined = next(line for line in lines if "joined" in line["message"])
    assert joined["site"] == 1 and joined["level"] == "info", joined
    assert len({line["session"] for line in lines if "session" in line}) == 1
    assert all(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", line["time"]) for line in lines)


def the_service_manager_is_told(binaries, folder):
    folder.mkdir()
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(str(folder / "notify"))
    manager.settimeout(20)
    environment = {"NOTIFY_SOCKET": str(folder / "notify"), "WATCHDOG_USEC": "400000"}
    with Server(binaries, folder, environment=environment):
        assert manager.recv(1000).startswith(b"READY=1\nSTATUS="), "ready comes first"
        beats = [manager.recv(1000) for _ in range(3)]
        assert beats == [b"WATCHDOG=1"] * 3, beats
    said = []
    while not said or said[-1] != b"STOPPING=1":
        said.append(manager.recv(1000))
    manager.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    binaries = parser.parse_args().bin
    for test in (orders_reach_a_running_server, keys_and_bans_outlive_a_restart,
                 the_log_is_json_that_names_session_and_site, the_service_manager_is_told):
        with tempfile.TemporaryDirectory() as folder:
            test(binaries, pathlib.Path(folder) / "server")
        print("ok", test.__name__, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
