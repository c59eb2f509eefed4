#!/usr/bin/env python3
"""/metrics and /healthz of a running tandem-server.

    python3 tests/server/metrics_test.py --bin build/release/bin
"""
import json
import re
import resource
import socket
import subprocess
import sys
import urllib.error
import urllib.request

from server_process import SCENE, Server, Site, run, wait_for

DISK_LIMIT = 4096  # bytes a file, when the disk is to fail
HANGING = 40  # clients


def metrics_port(server):
    return int(re.search(r"metrics on 127\.0\.0\.1 port (\d+)", server.log()).group(1))


def get(port, path):
    """Status and body; status 0 where the connection ended without an answer."""
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=20) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()
    except OSError:
        return 0, ""


def metrics(port):
    """The samples by name and labels, as they are written."""
    status, text = get(port, "/metrics")
    if status != 200:
        return {}
    return {line.rsplit(" ", 1)[0]: float(line.rsplit(" ", 1)[1])
            for line in text.splitlines() if not line.startswith("#")}


def a_site_is_counted_by_its_role_named_and_reports(binaries, folder):
    with Server(binaries, folder, "--metrics", ":0") as server:
        port = metrics_port(server)
        wait_for(lambda: metrics(port).get('tandem_sites{role="participant"}') == 0, "figures are served")
        with Site(binaries, folder, server.links("participant")[0], 'Be"n\\'):
            wait_for(lambda: metrics(port).get('tandem_sites{role="participant"}') == 1, "Ben is counted")
            assert r'tandem_site_info{site="1",role="participant",name="Be\"n\\"}' in metrics(port)
            ticks = 'tandem_site_ticks_total{site="1",role="participant"}'
            wait_for(lambda: metrics(port).get(ticks, 0) > 0, "Ben has reported")
            of = 'tandem_site_tick_seconds{site="1",role="participant",quantile="%s"}'
            times = [metrics(port)[of % quantile] for quantile in ("0.5", "0.99", "1")]
            assert 0 < times[0] <= times[1] <= times[2], times
            assert metrics(port)['tandem_site_round_trip_seconds{site="1",role="participant"}'] > 0
        wait_for(lambda: metrics(port).get('tandem_sites{role="participant"}') == 0, "Ben has left")
        assert metrics(port)['tandem_journal_durable_seconds_bucket{le="+Inf"}'] > 0


def a_sick_journal_is_told_and_so_is_its_cure(binaries, folder):
    with Server(binaries, folder, "--metrics", ":0") as server:
        port = metrics_port(server)
        away = folder / "away"

        def limit(size):
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

        def illness():
            status, text = get(port, "/healthz")
            return text if status == 503 else ""

        wait_for(lambda: get(port, "/healthz")[0] == 200, "the server is well")
        for harm, cure in ((lambda: limit(DISK_LIMIT), lambda: limit(resource.RLIM_INFINITY)),
                           (lambda: server.data.rename(away), lambda: away.rename(server.data))):
            harm()
            said = json.loads(wait_for(illness, "the journal fails"))
            assert said["status"] == "failing" and not said["journal"], said
            assert str(server.data) in said["reason"], said
            assert metrics(port)["tandem_journal_sound"] == 0
            cure()
            wait_for(lambda: get(port, "/healthz")[0] == 200, "the journal is well again")
            assert metrics(port)["tandem_journal_sound"] == 1


def clients_that_hang_delay_nobody(binaries, folder):
    with Server(binaries, folder, "--metrics", ":0") as server:
        port = metrics_port(server)
        hanging = []
        for i in range(HANGING):
            client = socket.create_connection(("127.0.0.1", port), 20)
            try:
                client.sendall([b"", b"GET /metr", b"GET /metrics HTTP/1.1\r\nHost: a\r\nX: ",
                                b"GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n"][i % 4])
            except OSError:
                pass  # one connection too many of one address
            hanging.append(client)
        # The session goes on meanwhile: orders are obeyed, and a site enters, is seen and is made to go.
        assert server.order("--revoke-links")[0] == 0
        with Site(binaries, folder, server.order("--invite-now", "participant")[1], "Ben") as ben:
            wait_for(lambda: "joined" in server.events(), "Ben has joined")
            assert server.order("--kick", "Ben")[0] == 0
            wait_for(lambda: ben.process.poll() is not None, "Ben has gone")
        wait_for(lambda: get(port, "/healthz")[0] == 200, "silent clients are dropped")
        for client in hanging:
            client.close()


def what_cannot_be_served_is_one_line_and_an_end(binaries, folder):
    folder.mkdir()

    def start(where):
        return subprocess.run(
            [binaries / "tandem-server", SCENE, "--listen", "127.0.0.1:0", "--data", folder / "data",
             "--quiet", "--metrics", where], capture_output=True, text=True, timeout=20)

    with socket.create_server(("127.0.0.1", 0)) as taken:
        where = "127.0.0.1:%d" % taken.getsockname()[1]
        done = start(where)
        assert done.returncode == 1 and done.stdout == "", done
        assert re.fullmatch(r"tandem-server: --metrics: cannot listen on 127\.0\.0\.1 port \d+: "
                            "Address already in use\n", done.stderr), done.stderr
    for where in ("x", ":", "127.0.0.1", "localhost:0", "::1:0", "127.0.0.1:65536", "127.0.0.1:-1",
                  "1.2.3:0"):
        done = start(where)
        assert done.returncode in (1, 2) and done.stdout == "", (where, done)
        assert len(done.stderr.splitlines()) == 1 and "--metrics" in done.stderr, (where, done.stderr)


if __name__ == "__main__":
    sys.exit(run(a_site_is_counted_by_its_role_named_and_reports,
                 a_sick_journal_is_told_and_so_is_its_cure,
                 clients_that_hang_delay_nobody, what_cannot_be_served_is_one_line_and_an_end))
