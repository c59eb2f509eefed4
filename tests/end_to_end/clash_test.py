#!/usr/bin/env python3
"""tandem check --clash, --distance and --measure on the sample scenes, and on arguments that make no sense.

    python3 tests/end_to_end/clash_test.py --bin build/release/bin
"""
import json
import os
import pathlib
import sys
import tempfile

from check_command import SCENES, binaries_of_command_line, expect, report, run, scene_of

# Everything of the samples stands 0.2 mm above its bench; the filter's fits are 0.1 mm wide.
NEAR = {"control_panel": 1, "filter_change": 7, "guided_path": 0, "peg_board": 4, "pump": 11,
        "solar_system": 0,
        "surfaces": 18}


def check_samples(binaries):
    for name, near in NEAR.items():
        scene = SCENES / f"{name}.glb"
        clashes = json.loads(run(binaries, scene, "--clash", "--clearance", "0.0005",
                                 "--json").stdout)["clashes"]
        counts = (clashes["hard"], clashes["touches"], clashes["clearance"])
        expect(counts == (0, 0, near), f"{name}: {counts}")
        expect(len(clashes["found"]) == near and all(f["may_collide"] for f in clashes["found"]),
               f"{name}: list")
        distances = [f["distance_m"] for f in clashes["found"]]
        expect(distances == sorted(distances), f"{name}: not in order")
        tight = [d for d in distances if d < 0.00015]
        expect(len(tight) == (3 if name == "filter_change" else 0), f"{name}: {tight}")
        expect(all(abs(d - 0.0001) < 2e-8 or abs(d - 0.0002) < 2e-8 for d in distances),
               f"{name}: {distances}")
        none = json.loads(run(binaries, scene, "--clash", "--json").stdout)["clashes"]
        expect(none["found"] == [], f"{name}: found something without a clearance")


def check_table(binaries):
    text = run(binaries, SCENES / "peg_board.glb", "--clash", "--clearance", "0.001").stdout
    expect("0 hard clashes, 0 touches, 4 pairs nearer than 1 mm; 5 parts" in text, text)
    expect(text.count("near ") == 4, text)
    expect("not pushed out" not in text, "the table speaks of overlaps where there are none")


def check_open_shells(binaries, folder):
    """A summary first, and no number where a shell is open."""
    box = [(x, y, z) for z in (-0.03, 0.03) for y in (-0.03, 0.03) for x in (-0.03, 0.03)]
    sides = [(0, 2, 3), (0, 3, 1), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2),
             (1, 3, 7), (1, 7, 5)]  # none at z = 0.03
    lid = [(4, 5, 7), (4, 7, 6)]
    small = [tuple(c / 3 for c in p) for p in box]
    scene = folder / "open.gltf"
    parts = {"cup": (box, sides, [0, 0, 0])}
    for i in range(12):
        parts[f"block {i}"] = (small, sides + lid, [0.03, 0.002 * i, 0.036])  # 4 mm under the opening
    parts["deep"] = (small, sides + lid, [0.035, 0, -0.01])
    scene.write_text(scene_of(parts))
    clashes = json.loads(run(binaries, scene, "--clash", "--json").stdout)["clashes"]
    of_cup = {f["b"]: f for f in clashes["found"] if f["a"] == "cup"}
    expect(all(f["depth_m"] is None and f["open"] for b, f in of_cup.items() if b != "deep"), f"{of_cup}")
    expect(clashes["open"] == 12 and clashes["hard"] > 20, f"{clashes['open']} {clashes['hard']}")
    expect(abs(of_cup["deep"]["depth_m"] - 0.005) < 1e-8 and not of_cup["deep"]["open"], f"{of_cup['deep']}")
    known = [f["depth_m"] for f in clashes["found"] if not f["open"]]
    expect(known == sorted(known, reverse=True) and len(clashes["worst"]) == 10, f"{clashes['worst']}")
    lines = run(binaries, scene, "--clash").stdout.splitlines()
    expect(lines[0].startswith(f"{clashes['hard']} hard clashes"), lines[0])
    expect("of 12 the depth cannot be known" in lines[0], lines[0])
    worst, everything = lines.index("the worst"), lines.index("all")
    expect(everything - worst == 13 and len(lines) - everything == 2 + len(clashes["found"]), f"{lines[:16]}")
    expect(sum("unknown" in line for line in lines[everything:]) == 12, "open shells have a number")
    text = run(binaries, scene, "--distance", "cup", "block 0").stdout
    expect("cannot be known because a shell is open" in text, text)


def check_distance(binaries):
    scene = SCENES / "peg_board.glb"
    result = run(binaries, scene, "--distance", "peg_0.5", "peg_0.1")
    expect(result.returncode == 0 and "peg_0.5 and peg_0.1 are" in result.stdout, result.stdout)
    found = json.loads(run(binaries, scene, "--distance", "peg_0.5", "peg_0.1", "--json").stdout)["distance"]
    a, b = found["point_a_m"], found["point_b_m"]
    between = sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5
    expect(abs(between - found["distance_m"]) < 1e-12, f"{found}")
    # Feet of 20 mm diameter 55 mm apart; the corners of their polygons need not face each other.
    expect(0.0330 < found["distance_m"] < 0.0360, f"{found}")
    expect((found["a"], found["b"], found["kind"]) == ("peg_0.5", "peg_0.1", "near"), f"{found}")


def check_measure(binaries):
    """Between two pegs as --distance says, and the places themselves."""
    pegs = ("peg_0.5", "peg_0.1")
    scene = SCENES / "peg_board.glb"
    distance = json.loads(run(binaries, scene, "--distance", *pegs, "--json").stdout)["distance"]
    places = [",".join(str(x) for x in distance[key]) for key in ("point_a_m", "point_b_m")]
    arguments = ("--measure", places[0], "--measure", places[1])
    found = json.loads(run(binaries, scene, *arguments, "--json").stdout)
    expect([place["part"] for place in found["places"]] == list(pegs), f"{found}")
    expect(found["parts"] == distance, f"{found['parts']} {distance}")
    expect(abs(found["between"]["distance_m"] - distance["distance_m"]) < 1e-12, f"{found}")
    text = run(binaries, scene, *arguments).stdout
    expect("peg_0.5 and peg_0.1 are" in text and "nearest edge" in text and "degrees" in text, text)
    # The pump's shaft has a seat of 24 mm for the impeller.
    shaft = json.loads(run(binaries, SCENES / "pump.glb", "--measure", "-0.15,0.05,0.12", "--json").stdout)
    cylinder = shaft["places"][0]["cylinder"]
    expect(cylinder and abs(cylinder["diameter_m"] - 0.024) < 1e-7 and not cylinder["hollow"], f"{shaft}")


def check_engine(binaries, engine):
    clashes = json.loads(run(binaries, engine, "--units", "mm", "--clash", "--json").stdout)["clashes"]
    expect(clashes["hard"] + clashes["touches"] > 90 and clashes["hard"] > 50,
           f"engine: {clashes['hard']} hard")
    depths = {frozenset((f["a"], f["b"])): f["depth_m"] for f in clashes["found"]}
    # By 1500 random points of each surface, with the winding number as the sum of solid angles.
    for pair, depth in ((("body #2", "body_8"), 7.033e-3),
                        (("rod_123-699_0_Parts_1", "Piston_123-844_0_Parts_1"), 2e-3),
                        (("body_4", "body_6"), 4.97e-4), (("rod_123-699_0_Parts_1", "body_24"), 1.037e-4)):
        found = depths.get(frozenset(pair), 0.0)
        expect(abs(found - depth) < 0.06 * depth, f"engine: {pair} {found} m deep, not {depth}")


def check_bad_arguments(binaries):
    scene = SCENES / "peg_board.glb"
    for arguments, word in ((("--distance", "peg_0.5", "cork"), "cork"),
                            (("--distance", "board", "board"), "twice"),
                            (("--distance", "board"), "--distance"),
                            (("--measure", "0,1"), "0,1"), (("--measure", "0,1,nan"), "0,1,nan"),
                            (("--measure", "0,1,2,3"), "0,1,2,3"), (("--measure", "0,0,0") * 3, "two"),
                            (("--measure", "0,0,0", "--clash"), "--measure"),
                            (("--clash", "--clearance", "-1"), "--clearance"),
                            (("--clash", "--clearance", "wide"), "--clearance"),
                            (("--clearance", "0.001"), "--clash"), (("--tolerance", "0.001"), "--clash"),
                            (("--clash", "--tolerance", "-0.1"), "--tolerance"),
                            (("--clash", "--clearance", "nan"), "--clearance")):
        result = run(binaries, scene, *arguments)
        lines = result.stderr.strip().splitlines()
        expect(result.returncode == 2 and len(lines) == 1 and word in lines[0] and not result.stdout,
               f"{arguments}: {result.returncode} {result.stderr!r}")


def main():
    binaries = binaries_of_command_line()
    check_samples(binaries)
    check_table(binaries)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        check_open_shells(binaries, pathlib.Path(folder))
    check_distance(binaries)
    check_measure(binaries)
    check_bad_arguments(binaries)
    engine = pathlib.Path(os.environ.get("TANDEM_DATA", "")) / "2CylinderEngine.glb"
    if engine.exists():
        check_engine(binaries, engine)
    return report()


if __name__ == "__main__":
    sys.exit(main())
