#!/usr/bin/env python3
"""tandem probe presses samples of surfaces.glb: the force at rest must be what each material says.

    python3 tests/end_to_end/probe_surfaces_test.py --bin build/release/bin
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

from check_command import SCENES, binaries_of_command_line, expect, report

SCENE = SCENES / "surfaces.glb"
TOP = 0.0062  # m, of every plate
HOLD = 3000  # ticks

# Part: column, row, place along x from its middle in m, depth in m, force at rest in N; None: it has given
# way.
PLATES = {
    "elastic": (0, 0, 0.0, 1e-3, 1.0), "damping": (1, 0, 0.0, 1e-3, 0.6), "friction": (2, 0, 0.0, 1e-3, 1.0),
    "waves": (5, 0, 1e-3, 1e-3, 1.0 + 0.15), "viscosity": (3, 1, 0.0, 1e-3, 1.0),
    "stick-slip": (5, 1, 0.0, 1e-3, 1.0), "magnet": (0, 2, 0.0, -4e-3, -0.8),
    "pop-through": (1, 2, 0.0, 1.6e-3, None),
    "viscoelastic": (2, 2, 0.0, 1e-3, 0.3), "plastic": (3, 2, 0.0, 1e-3, 0.8 + 0.2 * 120 / 1120),
}


def probe(binaries, folder, column, row, x, depth):
    """The last tick and the summary of a probe that comes down on a plate at 20 mm/s and stays."""
    steps = 500
    with open(folder / "path.csv", "w") as path:
        path.write("t,x,y,z\n")
        for i in range(steps + HOLD):
            height = 0.01 - (0.01 + depth) * min(i, steps) / steps
            place = ((column - 2.5) * 0.048 + x, TOP + height, (row - 1) * 0.048)
            path.write(f"{i * 1e-3:.3f},{place[0]:.9f},{place[1]:.9f},{place[2]:.9f}\n")
    subprocess.run([binaries / "tandem", "probe", SCENE, "--path", folder / "path.csv", "--force-limit", "20",
                    "--ticks", folder / "ticks.csv", "--json", folder / "probe.json"], check=True,
                   stdout=subprocess.DEVNULL)
    with open(folder / "ticks.csv") as ticks:
        return list(csv.DictReader(ticks))[-1], json.loads((folder / "probe.json").read_text())


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        for part, (column, row, x, depth, force) in PLATES.items():
            last, summary = probe(binaries, pathlib.Path(folder), column, row, x, depth)
            is_ = float(last["fy"])
            expect(math.isclose(is_, force or 0.0, abs_tol=2e-3), f"{part}: {is_} N, not {force} N")
            expect((summary["flags"].get("pop_through", 0) > 0) == (force is None),
                   f"{part}: {summary['flags']}")
            expect(summary["allocations"] == 0, f"{part}: ticks used the heap")
            expect(depth <= 0 or force is None or last["part"] == part,
                   f"{part}: the tool touched {last['part']}")
    return report()


if __name__ == "__main__":
    sys.exit(main())
