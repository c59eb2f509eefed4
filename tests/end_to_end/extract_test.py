#!/usr/bin/env python3
"""tandem extract takes an assembly apart in an order that works, and says what is in the way.

    python3 tests/end_to_end/extract_test.py --bin build/release/bin
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from check_command import binaries_of_command_line, expect, report

SCENE = pathlib.Path(__file__).resolve().parents[2] / "assets/scenes/filter_change.glb"


def extract(binaries, *arguments):
    command = [binaries / "tandem", "extract", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100)


def check_order(binaries, folder):
    out = folder / "order.json"
    done = extract(binaries, SCENE, "--order", "--json", out)
    expect(done.returncode == 0, done.stderr)
    told = json.loads(out.read_text())
    order = told["order"]
    expect(order.index("cap") < order.index("cartridge_old") and order.index("cap") < order.index("o_ring"),
           f"the cap is not first: {order}")
    parts = {part["part"]: part for part in told["parts"]}
    expect(parts["cap"]["free"] and parts["cap"]["axis"] == [0.0, 1.0, 0.0], f"{parts['cap']}")
    expect(parts["cap"]["blocked_by"] == [] and parts["cap"]["force_n"] >= 0, f"{parts['cap']}")


def check_part(binaries, folder):
    """What is blocked says by what; a way that is found can be felt by probe, without being in its way."""
    out, path = folder / "part.json", folder / "path.csv"
    done = extract(binaries, SCENE, "--part", "cartridge_old", "--json", out)
    expect(done.returncode == 0 and "blocked by" in done.stdout, done.stdout + done.stderr)
    told = json.loads(out.read_text())
    expect(told["order"] == [] and not told["parts"][0]["free"], f"{told}")
    expect("cap" in told["parts"][0]["blocked_by"], f"{told}")
    expect(extract(binaries, SCENE, "--part", "cap", "--path", path).returncode == 0, "the cap's path")
    felt = folder / "felt.json"
    probed = subprocess.run([binaries / "tandem", "probe", SCENE, "--tool", "part:cap", "--path", path,
                             "--json", felt], capture_output=True, text=True, timeout=100)
    expect(probed.returncode == 0, probed.stderr)
    touched = json.loads(felt.read_text())["contact"]["parts"]
    largest = max((part["largest_force_n"] for part in touched), default=0.0)
    expect(largest < 1.0, f"the way out presses with {largest} N")


def check_bad_input(binaries, folder):
    for arguments, said in [((SCENE,), "--part NAME and --order"),
                            ((SCENE, "--part", "cap", "--order"), "--part NAME and --order"),
                            ((SCENE, "--part", "capp"), "near it are 'cap'"),
                            ((SCENE, "--part", "bench"), "--movable bench"),
                            ((SCENE, "--order", "--force", "nan"), "--force"),
                            ((folder / "none.glb", "--order"), "none.glb"),
                            ((SCENE, "--part", "cap", "--path", folder / "no/such.csv"), "no/such.csv")]:
        done = extract(binaries, *arguments)
        expect(done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1,
               f"{arguments}: {done.returncode} {done.stderr}")


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_order(binaries, folder)
        check_part(binaries, folder)
        check_bad_input(binaries, folder)
    return report()


if __name__ == "__main__":
    sys.exit(main())
