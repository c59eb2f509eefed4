#!/usr/bin/env python3
"""tandem probe presses the button of the control panel: the forces of its ticks must follow the button's
profile.

    python3 tests/end_to_end/probe_controls_test.py --bin build/release/bin
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

from check_command import SCENES, binaries_of_command_line, expect, report

SCENE = SCENES / "control_panel.glb"
TOP = 0.031  # m, of the button at rest
CONTACT = 1200.0  # N/m, of its plastic
STEPS = 4500  # micrometres, one a tick


def resistance(q):
    """Of the button when it is q m in: spring with preload, and the click."""
    x = (q - 1.2e-3) / 0.3e-3
    bump = 0.4 * (1.0 + math.cos(math.pi * x)) if abs(x) < 1.0 else 0.0
    return 300.0 * (q + 1e-3) + bump


def expected():
    """Force for each micrometre of depth, and whether the button has snapped in the last 0.2 s."""
    forces, q, snapped = [], 0.0, -1000
    for i in range(1, STEPS + 1):
        x, before = 1e-6 * i, q
        while q < 2.5e-3 and q + resistance(q) / CONTACT < x:
            q += 1e-7
        if q - before > 50e-6:
            snapped = i
        forces.append((CONTACT * (x - q), i - snapped < 200))
    return forces


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        lead = 50
        with open(folder / "path.csv", "w") as path:
            path.write("t,x,y,z\n")
            for i in range(-lead, STEPS + 1):
                path.write(f"{(i + lead) * 1e-3:.3f},-0.09,{TOP - 1e-6 * i:.9f},-0.04\n")
        subprocess.run([binaries / "tandem", "probe", SCENE, "--path", folder / "path.csv",
                        "--force-limit", "20",
                        "--ticks", folder / "ticks.csv", "--json", folder / "probe.json"], check=True,
                       stdout=subprocess.DEVNULL)
        with open(folder / "ticks.csv") as ticks:
            rows = list(csv.DictReader(ticks))[lead + 1:]
        summary = json.loads((folder / "probe.json").read_text())
    worst, drop, last = 0.0, 0.0, 0.0
    for row, (force, ringing) in zip(rows, expected()):
        if not ringing:
            worst = max(worst, abs(float(row["fy"]) - force))
            drop = max(drop, last - force)
            last = force
    values = [float(row["control:start"]) for row in rows]
    known = summary["controls"]["start"]
    parts = {row["part"] for row in rows[20:] if row["part"]}
    print(f"largest error {worst:.4f} N, click {drop:.3f} N, parts touched {sorted(parts)}")
    # Its damper of 2 N*s/m adds to the profile where the cap moves fast.
    expect(worst <= 0.025, "the force leaves the profile of the button")
    expect(drop >= 0.15, "there is no click")
    expect(parts == {"start"}, "the tool touched something else")
    # Pressed to its stop at 2.5 mm, which is compared with the proxy: the cap stands where the tool rests on
    # it.
    gap = max(abs(TOP - float(row["py"]) - value) for row, value in zip(rows[20:], values[20:]))
    expect(0.0024 < max(values) < 0.0026 and gap <= 20e-6,
           f"the value of the button is not told: at most {max(values)}, {gap} from the proxy")
    expect(known["unit"] == "m" and abs(known["last"] - values[-1]) <= 1e-11
           and known["most"] >= max(values) - 1e-11,
           f"the summary tells another value: {known}")
    expect(summary["allocations"] == 0, "ticks used the heap")
    return report()


if __name__ == "__main__":
    sys.exit(main())
