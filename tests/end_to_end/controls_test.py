#!/usr/bin/env python3
"""The control panel between real processes on loopback: a scripted hand presses the button and others see it
go in and come back; values that are set arrive everywhere; who may not, may not.

    python3 tests/end_to_end/controls_test.py --bin build/release/bin
"""
import math
import pathlib
import sys
import tempfile

import session_test as session
from check_command import binaries_of_command_line
from session_test import FAILURES, Server, Site, check, poses_of
from steady import STEADY

session.SCENE = session.ROOT / "assets" / "scenes" / "control_panel.glb"
BUTTON = (-0.09, 0.023, -0.04)  # m, of the part at rest
TOP = 0.031  # m, where the button is touched


def press_and_set(binaries, folder):
    """What three sites report and trace of one press of the button and one of the slider."""
    server = Server(binaries, folder)
    try:
        above = [BUTTON[0], TOP + 0.01, BUTTON[2]]
        press = [{"t": 0.5, "do": "move", "to": above, "over_s": 1.0},
                 {"t": 2.0, "do": "press", "part": "start", "depth": 0.03, "over_s": 0.6},
                 {"t": 4.0, "do": "move", "to": above, "over_s": 0.6}]
        wishes = [{"t": 1.0, "do": "set", "control": "level", "value": 0.05},
                  {"t": 1.5, "do": "set", "control": "gauge layer", "value": 0.012}]
        ben = Site(binaries, folder, server.link("participant"), "ben", wishes, 60, trace=True)
        eve = Site(binaries, folder, server.link("observer"), "eve", None, 60, trace=True)
        for name in ('"ben"', '"eve"'):
            server.wait_until_said(name, "joined")
        ada = Site(binaries, folder, server.link("participant"), "ada", press, 6.5, trace=True)
        results = {"ada": ada.result()}
        server.wait_until_said("part level granted", '"ben"')
        results.update({site.name: site.leave() for site in (ben, eve)})
        return results
    finally:
        server.stop()


def test_panel(binaries, folder):
    results = press_and_set(binaries, folder)
    deepest = {}
    for name in ("ada", "ben", "eve"):
        rows = poses_of(folder / f"{name}.csv", "start", name == "ada")
        check(len(rows) > 50, f"{name} has poses of the button ({len(rows)})")
        deepest[name] = BUTTON[1] - min(p[1] for _, p in rows)
    print("the button went in by", {name: f"{1e3 * value:.2f} mm" for name, value in deepest.items()})
    check(deepest["ada"] > 1.5e-3, "the hand pressed the button past its click at 1.2 mm")
    for name in ("ben", "eve"):
        check(abs(deepest[name] - deepest["ada"]) < 1e-4, f"{name} saw it go in as far")
    for name, result in results.items():
        pose = result["poses"].get("start", list(BUTTON))
        check(math.dist(pose[:3], BUTTON) < 1e-4, f"at {name} the button has come back: {pose}")
    grabs = {grab["part"]: grab["answer"] for grab in results["ben"]["grabs"]}
    check(grabs.get("level") == "granted", f"a participant sets the slider: {grabs}")
    check(grabs.get("gauge layer") not in (None, "granted"), f"but not the instructor's switch: {grabs}")
    levels = {name: result["poses"]["level"][0] for name,
              result in results.items() if "level" in result["poses"]}
    check(len(levels) == 3 and all(abs(x - 0.08) < 1e-4 for x in levels.values()),
          f"all have its value: {levels}")


def main():
    binaries = binaries_of_command_line().resolve()
    session.with_own_cache()

    def attempt():
        with tempfile.TemporaryDirectory() as folder:
            test_panel(binaries, pathlib.Path(folder))

    try:
        STEADY.judge(attempt, FAILURES)
    except FAILURES as failure:
        print("FAILED:", failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
