#!/usr/bin/env python3
"""Sessions of real processes over a network with delay, jitter and losses: tests/support/network_relay.py on
loopback.

    python3 tests/end_to_end/network_test.py --bin build/release/bin [--only NAME]

What comes next waits until the server says that what it needs has happened. Figures of time are printed;
judged is only that nothing is faster than the network, and that a round trip belongs to this network and not
to another one.
"""
import argparse
import csv
import json
import pathlib
import select
import socket
import statistics
import struct
import subprocess
import sys
import time

from session_test import (PEG, ROOT, SCENE, Server, Site, check, distance, follower_errors, grasp, move,
                          passes, poses_of,
                          wait_for, with_own_cache)

RELAY = ROOT / "tests" / "support" / "network_relay.py"
WAN = {"one_way_ms": 25, "jitter": 0.2, "loss": 0.02, "duplicate": 0.01, "reorder": 0.01}


def release(t):
    return {"t": t, "do": "release"}


class Relay:
    """A network between sites, numbered from 0, and a port on this machine."""

    def __init__(self, port, sites, network):
        self.process = subprocess.Popen(
            [sys.executable, RELAY, "--server", f"127.0.0.1:{port}", "--sites", str(sites), "--network",
             json.dumps(network),
             "--orders"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port, self.ports = port, json.loads(self.process.stdout.readline())["ports"]

    def link(self, link, site):
        """A link of the server's, by way of this network."""
        return link.replace(f":{self.port}/", f":{self.ports[site]}/")

    def order(self, **what):
        self.process.stdin.write(json.dumps(what) + "\n")
        self.process.stdin.flush()

    def counts(self):
        self.order(report=True)
        return json.loads(self.process.stdout.readline())

    def end(self):
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


class Session:
    """A server, its network, and sites by name in the order in which they come."""

    def __init__(self, binaries, folder, sites, network):
        self.binaries, self.folder = binaries, folder
        self.server = Server(binaries, folder)
        self.relay = Relay(self.server.port, sites, network)
        self.sites = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for site in self.sites:
            if site.process.poll() is None:
                site.kill()
        self.server.stop()
        self.relay.end()

    def join(self, name, script, extra=()):
        link = self.relay.link(self.server.link("participant"), len(self.sites))
        site = Site(self.binaries, self.folder, link, name, script, 120, trace=True, extra=extra)
        self.sites.append(site)
        self.server.wait_until_said(f'"{name}"', "joined")
        return site

    def wait_until_said(self, *words):
        self.server.wait_until_said(*words)

    def leave(self, *sites):
        """They go; what each of them reports."""
        return [site.leave() for site in sites]


def check_ownership(*results):
    """No site ever saw an epoch go back, and no two saw an epoch with different owners."""
    owner = {}
    for result in results:
        newest = {}
        for note in result["ownership"]:
            part, epoch = note["part"], note["epoch"]
            check(epoch >= newest.get(part, 0), f"epochs only grow: {result['ownership']}")
            newest[part] = epoch
            if note["owner"]:
                check(owner.setdefault((part, epoch), note["owner"]) == note["owner"],
                      f"one owner of {part} in {epoch}")


def check_network(session, index, result, one_way, figures):
    """A site's figures are those of its network, and its loss that which the relay counted."""
    # Two legs, each up to 20 % faster; a machine that stood still shows as a longer one.
    check(0.8 * one_way - 0.1 < result["round_trip_ms"] < 2.5 * one_way + 50.0,
          f"round trip: {result['round_trip_ms']} ms")
    counts = session.relay.counts()["sites"][index]
    for way in ("up", "down"):
        share = counts[way].get("lost", 0) / counts[way]["datagrams"]
        measured = result[f"loss_{way}"]
        # The site counts updates alone, and hears few of hands that are still.
        traffic = result["received" if way == "down" else "sent"]
        updates = max(1, traffic["parts"]["packets"] + traffic["presence"]["packets"])
        chance = 3 * (share * (1 - share) / updates) ** 0.5
        check(abs(share - measured) < 0.015 + chance,
              f"lost {way}: {share} says the relay, {measured} the site")
    figures.setdefault("round_trip_ms", {})[session.sites[index].name] = result["round_trip_ms"]


def newest(session, name):
    """Session time of the last whole row that a site has written so far, us: a moment ago."""
    written = (session.folder / f"{name}.csv").read_text()
    return int(written.rpartition("\n")[0].splitlines()[-1].split(",")[0])


def check_follower(session, owner, follower, figures, when=lambda session_us: True):
    followed = [row for row in poses_of(session.folder / f"{follower}.csv", PEG, False) if when(row[0])]
    errors = follower_errors(poses_of(session.folder / f"{owner}.csv", PEG, True), followed)
    moving = sorted(error for error, speed in errors if speed > 0.05)
    check(len(moving) > 50, f"{follower} saw the part move ({len(moving)} poses)")
    median = statistics.median(moving)
    figures.setdefault("follower_error_mm", {})[follower] = {"median": 1e3 * median, "max": 1e3 * moving[-1]}
    check(median < 2e-3, f"{follower} is within 2 mm of {owner} (median {1e3 * median:.3f} mm)")


def check_same_pose(*results):
    for result in results[1:]:
        apart = distance(result["poses"][PEG], results[0]["poses"][PEG])
        who = f"site {result['site']} is {1e3 * apart} mm from site {results[0]['site']}"
        check(apart < 1e-5, f"all end with the same pose: {who}")


def test_relay(binaries, folder, figures):
    """The network itself: never too fast, loses and doubles as many as it should, reorders, and is dark when
    it is told to."""
    with (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server,
          socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as site):
        server.bind(("127.0.0.1", 0))
        relay = Relay(server.getsockname()[1], 1,
                      {"one_way_ms": 40, "jitter": 0.2, "loss": 0.36, "duplicate": 0.19})
        try:
            site.connect(("127.0.0.1", relay.ports[0]))
            def arrived(count):
                """Numbers, and shortest time on the way, of what comes when so many are sent."""
                numbers, shortest = [], float("inf")
                for number in range(count + 1):
                    if number < count:
                        site.send(struct.pack("<qd", number, time.monotonic()))
                    # After the last one, until nothing has come for a second.
                    while select.select([server], [], [], 0.0005 if number < count else 1.0)[0]:
                        arrived_number, sent = struct.unpack("<qd", server.recv(64))
                        numbers.append(arrived_number)
                        shortest = min(shortest, time.monotonic() - sent)
                return numbers, shortest

            numbers, shortest = arrived(2000)
            # A leg has half of the delay, 1 - sqrt(1 - p) of the rest: 20 % lost, 10 % doubled.
            check(0.016 <= shortest + 1e-4,
                  f"no datagram is faster than 20 ms less 20 %: {1e3 * shortest} ms")
            check(abs(len(set(numbers)) / 2000 - 0.8) < 0.04, f"a fifth is lost: {len(set(numbers))} came")
            check(abs(len(numbers) / len(set(numbers)) - 1.1) < 0.03, f"a tenth comes twice: {len(numbers)}")
            check(numbers != sorted(numbers), "some overtake others")
            relay.order(loss=0.0, duplicate=0.0, jitter=0.0)
            wait_for(lambda: relay.counts(), "the relay has heard")
            numbers, _ = arrived(500)
            check(numbers == list(range(500)), "all, once and in order")
            relay.order(blackout={"for_s": 60})
            wait_for(lambda: relay.counts(), "the relay has heard")
            check(arrived(100)[0] == [], "nothing in the dark")
            relay.order(blackout={"for_s": 60, "burst": True})
            wait_for(lambda: relay.counts(), "the relay has heard")
            check(arrived(100)[0] == [], "nothing in the dark")
            relay.order(blackout={"for_s": 0})
            check(arrived(1)[0] == [*range(100), 0], "what was kept, then what is new")
            figures["relay_late_ms"] = relay.counts()["late_ms"]
        finally:
            relay.end()


def test_hand_over(binaries, folder, figures):
    """25 ms, 20 % jitter, 2 % loss: one takes a part, moves it, lets it go; another one has seen that, then
    takes it."""
    with Session(binaries, folder, 3, WAN) as session:
        eve = session.join("eve", None)
        ada = session.join("ada", [grasp(1.0), move(2.2, [0.0, 0.2, 0.0], 0.75), release(4.0)])
        session.wait_until_said(PEG, "released by", '"ada"')
        ben = session.join("ben", [grasp(1.0), move(2.2, [0.05, 0.0, 0.0], 0.75), release(4.0)])
        session.wait_until_said(PEG, "released by", '"ben"')
        results = session.leave(eve, ada, ben)
        check_ownership(*results)
        check_same_pose(*results)
        check_follower(session, "ada", "eve", figures)
        check_follower(session, "ben", "ada", figures)
        pose = results[0]["poses"][PEG]
        check(pose[1] > 0.15 and pose[0] > -0.03, f"moved by both: {pose}")
        for index, result in enumerate(results):
            check(result["reconnects"] == 0 and result["state_over_udp"],
                  f"connected, by datagrams: {result}")
            check_network(session, index, result, WAN["one_way_ms"], figures)
        for result in results[1:]:
            check([grab["answer"] for grab in result["grabs"]] == ["granted"],
                  f"no grant is lost: {result['grabs']}")
        counts = session.relay.counts()
        # Of all sites together: one that says little may lose or double nothing in a few seconds.
        check(all(sum(site[way].get(what, 0) for site in counts["sites"]) > 0 for way in ("up", "down")
                  for what in ("lost", "duplicated", "overtaken")),
              f"the network was as bad as it should be: {counts}")
        figures["relay_late_ms_in_session"] = counts["late_ms"]


def test_without_datagrams(binaries, folder, figures):
    """Where no datagram passes, state goes over TLS; by datagrams once they pass, and over TLS again when
    they do not."""
    network = {"one_way_ms": 50, "jitter": 0.2, "loss": 1.0}
    with Session(binaries, folder, 3, network) as session:
        eve = session.join("eve", None)
        ada = session.join("ada", [grasp(1.0), move(2.2, [0.0, 0.2, 0.0], 0.75), release(4.0)])
        session.wait_until_said(PEG, "released by", '"ada"')
        result, = session.leave(ada)
        check(not result["state_over_udp"] and result["reconnects"] == 0, "over TLS")
        one_way = network["one_way_ms"]
        check(0.8 * one_way - 0.1 < result["round_trip_ms"] < 2.5 * one_way + 50.0,
              f"round trip: {result['round_trip_ms']} ms")
        check(not any("passed" in site[way] for site in session.relay.counts()["sites"]
                      for way in ("up", "down")),
              "no datagram passed")

        session.relay.order(loss=0.0)
        wait_for(lambda: session.relay.counts()["sites"][0]["down"].get("passed", 0) > 50,
                 "eve is sent datagrams")
        ben = session.join("ben", [grasp(1.0), move(6.0, [0.05, 0.0, 0.0], 0.75), release(8.0)])
        session.wait_until_said(PEG, "granted", '"ben"')
        # From before ben moves it: 2 s without datagrams, and both go back to TLS.
        session.relay.order(loss=1.0)
        session.wait_until_said(PEG, "released by", '"ben"')
        results = [result, *session.leave(eve, ben)]
        check_ownership(*results)
        check_same_pose(*results[1:])
        check(not any(result["state_over_udp"] for result in results), "over TLS again")
        check(not any(result["reconnects"] for result in results), "nobody was cut off")
        check_follower(session, "ada", "eve", figures)
        check_follower(session, "ben", "eve", figures)


def test_blackouts(binaries, folder, figures):
    """A dark second while a part is moved: it stays its owner's. Longer than its lease: it is another one's,
    for all."""
    with Session(binaries, folder, 3, WAN) as session:
        eve = session.join("eve", None)
        sway = {"t": 2.5, "do": "sine", "axis": [0.0, 1.0, 0.0], "amplitude": 0.03, "hz": 0.5, "for_s": 100}
        ada = session.join("ada", [grasp(1.0), move(2.0, [0.0, 0.12, 0.0], 0.5), sway])
        session.wait_until_said(PEG, "granted", '"ada"')
        time.sleep(2.0)  # until it sways
        light = [newest(session, "ada")]
        for burst in (False, True):
            session.relay.order(blackout={"for_s": 1.0, "burst": burst})
            time.sleep(3.0)
            light.append(newest(session, "ada"))
        check(not session.server.said(PEG, "is free") and not session.server.said("lost"),
              "a second is no reason to lose it")

        session.relay.order(blackout={"for_s": 60, "site": 1, "burst": True})
        session.wait_until_said(PEG, "is free")
        ben = session.join("ben", [grasp(1.0), move(2.2, [0.05, 0.0, 0.0], 0.75), release(4.0)])
        session.wait_until_said(PEG, "released by", '"ben"')
        session.relay.order(blackout={"for_s": 0})
        time.sleep(3.0)  # until ada, who has begun her connection anew, is back
        results = session.leave(eve, ada, ben)
        check_ownership(*results)
        check_same_pose(*results)
        # Before it was dark, and well after each time; what has been written of it is some tenths of a second
        # old.
        for end in light:
            check_follower(session, "ada", "eve", figures, lambda at: end - 700000 < at <= end)
        owners = [note["owner"] for note in results[0]["ownership"] if note["part"] == PEG]
        check(owners == [results[1]["site"], 0, results[2]["site"], 0],
              f"ada's, nobody's, ben's, nobody's: {owners}")
        check([grab["answer"] for grab in results[2]["grabs"]] == ["granted"],
              f"no grant is lost: {results[2]['grabs']}")
        check(results[1]["ownership"][-1]["epoch"] == results[2]["ownership"][-1]["epoch"],
              "ada has heard of it")
        counts = session.relay.counts()["sites"]
        check(all(counts[index]["up"]["blacked_out"] > 0 for index in (0, 1)), f"it was dark: {counts}")


def replayed(session, recording):
    """(summary, [(t, site, force)]) of a recording, from its beginning."""
    summary, forces = session.folder / "summary.json", session.folder / "forces.csv"
    subprocess.run([session.binaries / "tandem", "replay", recording, "--headless", "--scene", SCENE,
                    "--json", summary,
                    "--forces", forces], check=True, timeout=60, stdout=subprocess.DEVNULL)
    with open(forces, newline="") as file:
        rows = [(float(row["t"]), int(row["site"]), tuple(float(row[axis]) for axis in "xyz"))
                for row in csv.DictReader(file)]
    return json.loads(summary.read_text()), rows


def mean_force(rows, site, begin, end):
    """Over a time of a recording, along x, N."""
    return statistics.fmean(force[0] for t, who, force in rows if who == site and begin <= t < end)


def test_shared_grasp(binaries, folder, figures):
    """Two hold a part and pull against each other: both feel it. One lets go; then it shares again, and
    inherits the part."""
    with Session(binaries, folder, 2, WAN) as session:
        recording = folder / "ada.rec"
        ada = session.join("ada", [grasp(1.0), move(2.2, [0.0, 0.12, 0.0], 0.75)],
                           extra=("--record", recording))
        session.wait_until_said(PEG, "granted", '"ada"')
        ben = session.join("ben", [grasp(3.0), move(5.0, [0.04, 0.0, 0.0], 0.5), release(8.0), grasp(10.0)])
        session.wait_until_said(PEG, '"ben"', "lets part")
        wait_for(lambda: session.server.count(PEG, '"ben"', "is a co-holder") == 2,
                 "ben holds it again", 60.0)
        time.sleep(1.0)
        results = session.leave(ada)
        session.wait_until_said(PEG, "is with", '"ben"')
        results += session.leave(ben)
        check_ownership(*results)
        owners = [note["owner"] for note in results[1]["ownership"] if note["part"] == PEG]
        check(owners == [results[0]["site"], results[1]["site"]],
              f"ada's, then ben's who shared it: {owners}")
        check(not any(result["reconnects"] or result["fault"] for result in results),
              "connected, and no fault")

        summary, rows = replayed(session, recording)
        shared = [(note["t"], note["sites"]) for note in summary["shared"] if note["part"] == PEG]
        check([sites for _, sites in shared[:3]] == [[results[1]["site"]], [], [results[1]["site"]]],
              f"shared: {shared}")
        (begin, _), (end, _), _ = shared[:3]
        felt = {}
        for result, name in zip(results, ("ada", "ben")):
            felt[name] = {"pulled": mean_force(rows, result["site"], end - 1.2, end - 0.2),
                          "before": mean_force(rows, result["site"], begin - 0.4, begin),
                          "after": mean_force(rows, result["site"], end + 1.0, end + 1.5)}
        figures["shared_grasp_n"] = felt
        # Arms, couplings and link give way, one after the other: of 4 cm some 0.6 N are left.
        check(felt["ada"]["pulled"] > 0.3 and felt["ben"]["pulled"] < -0.3,
              f"each is pulled to the other: {felt}")
        for name in felt:
            check(abs(felt[name]["before"]) < 0.1 and abs(felt[name]["after"]) < 0.1,
                  f"and only while both pull: {felt}")


TESTS = [test_relay, test_hand_over, test_without_datagrams, test_blackouts, test_shared_grasp]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--only")
    arguments = parser.parse_args()
    with_own_cache()
    figures, failures = {}, 0
    for test in TESTS:
        if not arguments.only or arguments.only in test.__name__:
            failures += not passes(test, arguments.bin.resolve(), figures)
    print(json.dumps(figures, indent=2))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
