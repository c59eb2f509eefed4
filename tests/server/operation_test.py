#!/usr/bin/env python3
"""What an operator has of a running tandem-server: orders, the audit table, the log, the service manager.

    python3 tests/server/operation_test.py --bin build/release/bin
"""
import json
import os
import re
import socket
import stat
import sys

from server_process import Server, Site, run, wait_for


def orders_reach_a_running_server(binaries, folder):
    with Server(binaries, folder) as server:
        assert stat.S_IMODE(os.stat(server.data / "control.sock").st_mode) == 0o600
        with Site(binaries, folder, server.links("participant")[0], "Ben") as ben:
            wait_for(lambda: "joined" in server.events(), "Ben is in the audit table")
            code, _, error = server.order("--kick", "Eve")
            assert code == 1 and "Eve" in error, (code, error)
            code, out, error = server.order("--rotate-keys")
            assert code == 0 and "1 connected site has a new ticket" in out, (out, error)
            code, out, _ = server.order("--kick", "Ben", "--ban")
            assert code == 0 and "banned" in out, out
            wait_for(lambda: ben.process.poll() is not None, "the site that is banned ends")
            assert "operator" in ben.log(), ben.log()
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
        link = re.sub(r":\d+(?=[/?])", ":" + server.port(), old, count=1)
        with Site(binaries, folder, link, "Eve") as eve:
            code = eve.process.wait(30)
        assert code != 0 and "not signed by this server" in eve.log(), eve.log()
        wait_for(lambda: "refused" in server.events(), "the refusal is in the table")


def the_log_is_json_that_names_session_and_site(binaries, folder):
    with Server(binaries, folder, "--log", "json") as server:
        with Site(binaries, folder, server.links("instructor")[0], "Ada"):
            wait_for(lambda: "Ada" in server.log(), "Ada is logged")
    lines = [json.loads(line) for line in server.log().splitlines()]
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


if __name__ == "__main__":
    sys.exit(run(orders_reach_a_running_server, keys_and_bans_outlive_a_restart,
                 the_log_is_json_that_names_session_and_site, the_service_manager_is_told))
