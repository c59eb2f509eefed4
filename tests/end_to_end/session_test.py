#!/usr/bin/env python3
"""A session of real processes and sockets on loopback: a server and headless sites, kill -9 of each in turn.

    python3 tests/end_to_end/session_test.py --bin build/release/bin [--soak SECONDS] [--json OUT]

Every wait is bounded; only processes started here are ended. Figures of time are printed, never judged.
"""
import argparse
import atexit
import bisect
import csv
import json
import math
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from steady import STEADY

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCENE = ROOT / "assets" / "scenes" / "peg_board.glb"
PEG = "peg_0.5"


class Failed(Exception):
    pass


def check(condition, what):
    if not condition:
        raise Failed(what)


def wait_for(condition, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        result = condition()
        if result:
            return result
        time.sleep(0.05)
    raise Failed(f"timed out waiting until {what}")


class Server:
    """tandem-server on a data directory; can be killed and started again on the same port."""

    def __init__(self, binaries, folder, extra=()):
        self.binaries, self.folder, self.port, self.process = binaries, folder, 0, None
        self.extra = list(extra)
        self.starts = 0
        self.start()

    def start(self):
        self.starts += 1
        self.out_path = self.folder / f"server{self.starts}.out"
        self.err_path = self.folder / f"server{self.starts}.err"
        self.process = subprocess.Popen(
            [self.binaries / "tandem-server", SCENE, "--listen", f"127.0.0.1:{self.port}", "--data",
             self.folder / "data", "--invite", "participant=6", "--invite", "observer=1", "--invite",
             "instructor=1",
             *self.extra],
            stdout=open(self.out_path, "w"), stderr=open(self.err_path, "w"))
        wait_for(lambda: self.dead() or len(self.links("participant")) >= 6, "the server prints its links")
        if self.dead():
            raise Failed("the server ended: " + self.err_path.read_text())
        self.used = {"participant": 0, "observer": 0, "instructor": 0}
        self.port = int(self.links("participant")[0].split("//")[1].split("/")[0].rsplit(":", 1)[1])

    def dead(self):
        return self.process.poll() is not None

    def links(self, role):
        return [line.split()[1] for line in self.out_path.read_text().splitlines()
                if line.startswith(role) and len(line.split()) == 2]

    def link(self, role):
        self.used[role] += 1
        return self.links(role)[self.used[role] - 1]

    def count(self, *words):
        """Lines of its log since its last start that hold all of these."""
        return sum(all(word in line for word in words) for line in self.err_path.read_text().splitlines())

    def said(self, *words):
        return self.count(*words) > 0

    def wait_until_said(self, *words):
        wait_for(lambda: self.dead() or self.said(*words), "the server says: " + " ".join(words), 60.0)
        check(not self.dead(), "the server lives")

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self):
        if not self.dead():
            self.process.terminate()
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()


def with_own_cache():
    """From here on nothing that other programs have kept is found; removed in the end."""
    folder = tempfile.mkdtemp(prefix="tandem-cache-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ["XDG_CACHE_HOME"] = folder


def made_ready(binaries, cache):
    """Puts what contact of the scene's parts needs into a site's cache: its hand begins when that is ready,
    and the scripts of several sites are to begin together. False on a machine (or under a sanitizer) that
    takes too long for it."""
    kept = pathlib.Path(os.environ["XDG_CACHE_HOME"]) / ("models-" + SCENE.stem)
    if not kept.exists():
        kept.mkdir()
        try:
            subprocess.run([binaries / "tandem", "check", SCENE, "--models"], check=True, timeout=180,
                           stdout=subprocess.DEVNULL, env={**os.environ, "XDG_CACHE_HOME": str(kept)})
        except subprocess.TimeoutExpired:
            print("  parts pass through each other here: making their models takes too long")
            (kept / "none").touch()
    cache.mkdir(exist_ok=True)
    for path in (kept / "tandem").glob("*.field"):
        if not (cache / path.name).exists():
            shutil.copy(path, cache)
    return not (kept / "none").exists()


class Site:
    """tandem join --headless with a scripted hand."""

    def __init__(self, binaries, folder, link, name, script, duration, trace=False, extra=(),
                 shows=False):
        self.name, self.folder, self.collides = name, folder, False
        self.json_path = folder / f"{name}.json"
        self.trace_path = folder / f"{name}.csv"
        arguments = [binaries / "tandem", "join", link, "--headless", "--name", name, "--duration",
                     str(duration), "--json", self.json_path, "--cache", folder / "cache", *extra]
        arguments += [] if shows else ["--quiet"]
        if script is not None:
            script_path = folder / f"{name}.script.json"
            script_path.write_text(json.dumps(script))
            arguments += ["--hand", script_path]
            if "--no-part-contact" not in extra:
                self.collides = made_ready(binaries, folder / "cache")
                arguments += [] if self.collides else ["--no-part-contact"]
        if trace:
            arguments += ["--trace", self.trace_path]
        self.err_path = folder / f"{name}.err"
        self.out_path = folder / f"{name}.out"
        self.process = subprocess.Popen(arguments, stdout=open(self.out_path, "w"),
                                        stderr=open(self.err_path, "w"))

    def result(self, seconds=40.0):
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise Failed(f"{self.name} did not end")
        check(code == 0, f"{self.name} ended with {code}: {self.err_path.read_text()}")
        result = json.loads(self.json_path.read_text())
        STEADY.stalls += result["stalls"]
        return result

    def leave(self):
        """Ends a site that would have stayed; what it reports."""
        time.sleep(1.0)  # what others did last may still be played out
        self.process.terminate()
        return self.result()

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def distance(a, b):
    return math.dist(a[:3], b[:3])


def poses_of(path, part, owned):
    """(session time in us, position) rows of one part in a trace, sorted."""
    rows = []
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if row["part"] == part and (row["owned"] == "1") == owned:
                rows.append((int(row["session_us"]), tuple(float(row[c]) for c in "xyz")))
    rows.sort()
    return rows


def follower_errors(owner_rows, follower_rows):
    """Distance between follower and owner at the same session time, the play-out delay taken out; m, and
    owner speed."""
    times = [t for t, _ in owner_rows]
    errors = []
    for t, p in follower_rows:
        i = bisect.bisect_left(times, t)
        if i == 0 or i == len(times) or times[i] - times[i - 1] > 20000:
            continue
        (t0, a), (t1, b) = owner_rows[i - 1], owner_rows[i]
        s = (t - t0) / (t1 - t0) if t1 > t0 else 0.0
        expected = tuple(x + s * (y - x) for x, y in zip(a, b))
        speed = math.dist(a, b) / max(t1 - t0, 1) * 1e6
        errors.append((math.dist(expected, p), speed))
    return errors


def grasp(t, part=PEG, over=0.4):
    return {"t": t, "do": "grasp", "part": part, "over_s": over}


def move(t, by, over):
    return {"t": t, "do": "move_relative", "by": by, "over_s": over}


def test_contend(binaries, folder, figures):
    """Both grab one part at once: one owns it, the other shares it; who lets go last has it alone."""
    server = Server(binaries, folder)
    try:
        script = [grasp(1.0), move(2.2, [0.0, 0.05, 0.0], 0.5), {"t": 4.0, "do": "release"}]
        a = Site(binaries, folder, server.link("participant"), "ada", script, 7)
        b = Site(binaries, folder, server.link("participant"), "ben", script, 7)
        results = [a.result(), b.result()]
        answers = [grab["answer"] for result in results for grab in result["grabs"]]
        # Whoever did not know yet that it was owned is told so, and then shares it.
        late = [answer for answer in answers if answer != "granted"]
        check(len(answers) - len(late) == 1 and late in ([], ["somebody else holds it"]) and
              server.count(PEG, "is a co-holder") == 1, f"one owns it, one shares it: {answers}")
        check(server.count(PEG, "released by", "now with") <= 1 and server.said(PEG, "released by"),
              "nobody has it in the end")
        for site, result in zip((a, b), results):
            check(("held_without_contact" in result["flags_seen"]) == (not site.collides),
                  f"what {site.name} holds collides, unless told not to: {result['flags_seen']}")
        check(distance(results[0]["poses"][PEG], results[1]["poses"][PEG]) < 1e-5,
              "both end with the same pose")
    finally:
        server.stop()


def test_follow(binaries, folder, figures):
    """The follower's pose is the owner's, played out late."""
    server = Server(binaries, folder)
    try:
        # 0.2 m in 0.75 s at minimum jerk peaks at 0.5 m/s.
        motion = [grasp(1.0), move(2.2, [0.0, 0.2, 0.0], 0.75), move(3.2, [0.0, -0.15, 0.05], 0.75),
                  {"t": 4.6, "do": "release"}]
        follower = Site(binaries, folder, server.link("participant"), "ben", None, 60, trace=True)
        server.wait_until_said('"ben"', "joined")
        owner = Site(binaries, folder, server.link("participant"), "ada", motion, 7, trace=True)
        results = [owner.result(), follower.leave()]
        figures["grab_wait_ms"] = [grab["wait_ms"] for grab in results[0]["grabs"]]
        figures["round_trip_ms"] = [r["round_trip_ms"] for r in results]
        errors = follower_errors(poses_of(folder / "ada.csv", PEG, True),
                                 poses_of(folder / "ben.csv", PEG, False))
        moving = [e for e, speed in errors if speed > 0.05]
        check(len(moving) > 200, f"the follower saw the part move ({len(moving)} poses)")
        figures["follower_error_mm"] = {"max": 1e3 * max(moving), "mean": 1e3 * sum(moving) / len(moving),
                                        "peak_speed_m_s": max(speed for _, speed in errors)}
        check(max(speed for _, speed in errors) > 0.4, "the part moved at about 0.5 m/s")
        # The bound for every pose is held on virtual time (tests/sync/replica/play_out_test.cpp). Here a
        # process that the machine puts to sleep in the middle of a motion shows for a moment: the tail is
        # printed, the median judged.
        moving.sort()
        median, p95 = moving[len(moving) // 2], moving[int(0.95 * len(moving))]
        figures["follower_error_mm"].update(median=1e3 * median, p95=1e3 * p95)
        check(median < 1e-3, f"the follower is within 1 mm of the owner (median {1e3 * median:.3f} mm)")
        check(distance(results[0]["poses"][PEG], results[1]["poses"][PEG]) < 1e-5,
              "both end with the same pose")
    finally:
        server.stop()


def test_server_killed(binaries, folder, figures):
    """kill -9 of the server while a part is held: with the same data it goes on, the holder keeps its
    part."""
    server = Server(binaries, folder)
    try:
        script = [grasp(1.0), move(2.0, [0.0, 0.10, 0.0], 1.0), move(6.0, [0.05, 0.0, 0.0], 1.0),
                  {"t": 8.5, "do": "release"}]
        b = Site(binaries, folder, server.link("observer"), "eve", None, 60)
        server.wait_until_said('"eve"', "joined")
        a = Site(binaries, folder, server.link("participant"), "ada", script, 12)
        server.wait_until_said(PEG, "granted", '"ada"')
        time.sleep(2.2)  # between its two moves
        server.kill()
        time.sleep(0.3)
        server.start()
        for name in ('"ada"', '"eve"'):
            server.wait_until_said(name, "came back")
        late = Site(binaries, folder, server.link("participant"), "late", None, 60)
        server.wait_until_said('"late"', "joined")
        results = {"ada": a.result(), "eve": b.leave(), "late": late.leave()}
        for name in ("ada", "eve"):
            check(results[name]["reconnects"] >= 1, f"{name} came back")
        epochs = [note["epoch"] for note in results["ada"]["ownership"] if note["part"] == PEG]
        check(epochs == sorted(epochs), f"epochs only grow: {epochs}")
        owners = [note["owner"] for note in results["ada"]["ownership"] if note["part"] == PEG
                  and note["owner"]]
        check(set(owners) == {results["ada"]["site"]}, f"nobody else ever owned it: {owners}")
        start = results["ada"]["poses"][PEG]
        for name in ("eve", "late"):
            check(distance(results[name]["poses"][PEG], start) < 1e-5, f"{name} has the released pose")
        check(start[1] > 0.08, f"the part moved before and after the crash: {start}")
        check(start[0] > -0.03, f"the move after the restart counts: {start}")
    finally:
        server.stop()


def test_server_hangs(binaries, folder, figures):
    """A server that stands still keeps its connections open: a site says soon that it does not answer, and
    comes back when it does. How soon exactly is a test of pings, on virtual time."""
    server = Server(binaries, folder)
    try:
        eve = Site(binaries, folder, server.link("observer"), "eve", None, 60, shows=True)
        server.wait_until_said('"eve"', "joined")
        time.sleep(1.0)  # until its pings are answered
        server.process.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        wait_for(lambda: "the server does not answer" in eve.out_path.read_text(), "eve says so", 10.0)
        figures["server_hangs_noticed_s"] = time.monotonic() - begin
        server.process.send_signal(signal.SIGCONT)
        server.wait_until_said('"eve"', "came back")
        check(eve.leave()["reconnects"] >= 1, "eve came back")
    finally:
        server.process.send_signal(signal.SIGCONT)
        server.stop()


def test_two_hands(binaries, folder, figures):
    """One person with two hands at a part: asked for once, lifted by both, kept by the second when the first
    lets go."""
    server = Server(binaries, folder)
    try:
        second = folder / "second.json"
        second.write_text(json.dumps([grasp(1.4), move(2.4, [0.0, 0.05, 0.0], 0.6),
                                      move(4.2, [0.0, 0.03, 0.0], 0.4)]))
        a = Site(binaries, folder, server.link("participant"), "ada",
                 [grasp(0.8), move(2.4, [0.0, 0.05, 0.0], 0.6), {"t": 3.4, "do": "release"}], 5.5,
                 extra=("--no-part-contact", "--second-hand", second))
        result = a.result()
        check([g["answer"] for g in result["grabs"]] == ["granted"], f"asked once: {result['grabs']}")
        check(result["second_hand"]["held"] == PEG, f"in the second hand: {result['second_hand']}")
        check(result["second_hand"]["largest_force_n"] > 0.05, f"felt by it: {result['second_hand']}")
        check(result["poses"][PEG][1] > 0.065, f"lifted by both, then by the second: {result['poses'][PEG]}")
        owners = [note["owner"] for note in result["ownership"] if note["part"] == PEG]
        check(owners == [result["site"]], f"it stayed here: {owners}")
    finally:
        server.stop()


def test_owner_killed(binaries, folder, figures):
    """kill -9 of the owner: the part stays where it was last seen; after the lease somebody else takes it."""
    server = Server(binaries, folder)
    try:
        a = Site(binaries, folder, server.link("participant"), "ada",
                 [grasp(0.8), move(1.5, [0.0, 0.1, 0.0], 0.8)], 60)
        server.wait_until_said(PEG, "granted", '"ada"')
        # Its hand begins no earlier than now: its grasp comes when the lease of whom is killed below is over.
        b = Site(binaries, folder, server.link("participant"), "ben",
                 [grasp(7.5), move(9.0, [0.0, 0.05, 0.0], 0.5), {"t": 10.0, "do": "release"}], 12,
                 extra=("--no-part-contact",))
        time.sleep(2.5)  # for the move
        server.wait_until_said('"ben"', "joined")
        a.kill()
        result = b.result()
        notes = [n for n in result["ownership"] if n["part"] == PEG]
        check(any(n["owner"] == 0 for n in notes), "the dead site's part was freed")
        check(any(g["answer"] == "granted" for g in result["grabs"]),
              f"and taken by the other: {result['grabs']}")
        check("held_without_contact" in result["flags_seen"], "who does without contact is told so")
        check(result["poses"][PEG][1] > 0.12, f"from where it was last seen: {result['poses'][PEG]}")
    finally:
        server.stop()


def run_once(arguments, expect, what, words):
    done = subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=30)
    check(done.returncode == expect, f"{what}: exit {done.returncode}, expected {expect}: {done.stderr}")
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    check(len(lines) == 1, f"{what}: one line, not {lines}")
    check(any(word in lines[0] for word in words), f"{what}: says why: {lines[0]}")


def test_refusals(binaries, folder, figures):
    """Wrong, reused or altered links are refused in one line."""
    server = Server(binaries, folder)
    try:
        join = [binaries / "tandem", "join"]
        options = ["--headless", "--quiet", "--duration", "0.5", "--cache", folder / "cache"]
        good = server.link("participant")
        run = subprocess.run([*join, good, *options], timeout=30, stderr=subprocess.PIPE, text=True)
        check(run.returncode == 0, f"a good link works: {run.stderr}")
        run_once([*join, good, *options], 2, "a used link", ["used"])
        altered = server.link("participant")
        head, token = altered.split("token=")
        middle = len(token.split("&")[0]) // 2
        altered = head + "token=" + token[:middle] + ("A" if token[middle] != "A"
                                                      else "B") + token[middle + 1:]
        run_once([*join, altered, *options], 2, "an altered token", ["credential", "sign", "token"])
        pin = server.link("participant")
        pin = pin[:-1] + ("0" if pin[-1] != "0" else "1")
        run_once([*join, pin, *options], 2, "a wrong pin", ["key"])
        run_once([*join, "tandem://127.0.0.1:1/participant?token=x&pin=" + "0" * 64, *options], 2,
                 "no server",
                 ["127.0.0.1:1"])
        run_once([*join, "http://example.org", *options], 2, "no link at all", ["link"])
        run_once([binaries / "tandem-server", folder / "missing.glb", "--data", folder / "other"], 2,
                 "no scene",
                 ["missing.glb"])
    finally:
        server.stop()


def test_scene_transfer(binaries, folder, figures):
    """A broken-off transfer goes on where it ended; a damaged beginning is refused once, then fetched
    anew."""
    server = Server(binaries, folder)
    try:
        def join():
            return subprocess.run([binaries / "tandem", "join", server.link("participant"), "--headless",
                                   "--quiet",
                                   "--duration", "0.3", "--cache", folder / "cache"],
                                  stderr=subprocess.PIPE, text=True,
                                  timeout=30)

        check(join().returncode == 0, "the first visit fetches the scene")
        whole, = (folder / "cache" / "received").glob("*.scene")
        package = whole.read_bytes()
        part = whole.with_suffix(".part")
        whole.unlink()
        part.write_bytes(package[:len(package) // 2])
        check(join().returncode == 0, "the second visit goes on in the middle")
        check(whole.read_bytes() == package and not part.exists(), "and ends with the same package")
        whole.unlink()
        part.write_bytes(bytes(len(package) // 2))
        damaged = join()
        check(damaged.returncode == 2 and "damaged" in damaged.stderr,
              f"a damaged beginning is found: {damaged.stderr}")
        check(join().returncode == 0 and whole.read_bytes() == package, "and fetched anew")
    finally:
        server.stop()


def test_fault_signal(binaries, folder, figures):
    """A site without a window: USR1 clears a fault, and does not end it."""
    server = Server(binaries, folder)
    try:
        site = Site(binaries, folder, server.link("participant"), "ada", [], 4)
        server.wait_until_said('"ada"', "joined")
        time.sleep(1.0)
        site.process.send_signal(signal.SIGUSR1)
        result = site.result()
        check(result["end"] == "done" and result["fault_clears"] == 1,
              f"one signal, heard: {result['fault_clears']}")
        check(result["fault"] is None, "no fault is left")
    finally:
        server.stop()


def soak(binaries, folder, seconds):
    """People come, take parts, leave or are killed; the server is killed now and then; it must all go on."""
    server = Server(binaries, folder)
    random.seed(1)
    end = time.monotonic() + seconds
    rounds = 0
    try:
        while time.monotonic() < end:
            rounds += 1
            sites = [Site(binaries, folder, server.link("participant"), f"s{i}",
                          [grasp(0.5 + 0.2 * i, part), move(1.5, [0.0, 0.05, 0.0], 0.5),
                           {"t": 2.5, "do": "release"}], 5)
                     for i, part in enumerate([PEG, PEG, "peg_0.1"])]
            time.sleep(2.0)
            victim = random.randrange(4)
            if victim < 3:
                sites[victim].kill()
            else:
                server.kill()
                server.start()
            for i, site in enumerate(sites):
                if i != victim:
                    site.result()
            check(not server.dead(), "the server lives")
            server.used = {role: max(0, len(server.links(role)) - 6) if role == "participant" else 0
                           for role in server.used}
    finally:
        server.stop()
    print(f"soak: {rounds} rounds in {seconds:.0f} s")


def passes(test, binaries, figures):
    """Runs a test in a folder of its own, and says how it ended."""
    def attempt():
        with tempfile.TemporaryDirectory(prefix="tandem-e2e-") as directory:
            try:
                test(binaries, pathlib.Path(directory), figures)
            except FAILURES:
                for log in sorted(pathlib.Path(directory).glob("*.err")):
                    text = log.read_text().strip()
                    if text:
                        print(f"  {log.name}: " + text[-600:].replace("\n", "\n    "))
                raise

    try:
        STEADY.judge(attempt, FAILURES)
        print(f"passed  {test.__name__}", flush=True)
        return True
    except FAILURES as error:
        print(f"FAILED  {test.__name__}: {error}", flush=True)
        return False


FAILURES = (Failed, subprocess.TimeoutExpired, OSError, KeyError, IndexError)
TESTS = [test_contend, test_follow, test_server_killed, test_server_hangs, test_two_hands, test_owner_killed,
         test_refusals, test_scene_transfer, test_fault_signal]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--only")
    parser.add_argument("--soak", type=float)
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    binaries = arguments.bin.resolve()
    with_own_cache()
    figures, failures = {}, 0
    if arguments.soak:
        with tempfile.TemporaryDirectory(prefix="tandem-soak-") as directory:
            soak(binaries, pathlib.Path(directory), arguments.soak)
        return 0
    for test in TESTS:
        if not arguments.only or arguments.only in test.__name__:
            failures += not passes(test, binaries, figures)
    print(json.dumps(figures, indent=2))
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
