#!/usr/bin/env python3
"""tandem check tells what contact of parts in the hand is computed with, and warns of fits that facets cannot
show.

    python3 tests/end_to_end/check_contact_test.py --bin build/release/bin
"""
import json
import math
import os
import pathlib
import sys
import tempfile

from check_command import binaries_of_command_line, expect, report, run, scene_of


def turned(profile, segments):
    """Points and triangles of a closed profile of (radius, height), turned about the z axis."""
    points = [(r * math.cos(a), r * math.sin(a), z)
              for a in (2 * math.pi * i / segments for i in range(segments)) for r, z in profile]
    n, triangles = len(profile), []
    for i in range(segments):
        for k in range(n):
            a, b = i * n + k, i * n + (k + 1) % n
            c, d = (a + n) % len(points), (b + n) % len(points)
            triangles += [(a, c, d), (a, d, b)]
    return points, triangles


def peg_in_ring(segments, clearance):
    """A peg of 20 mm less the clearance (mm, of diameters), half way in a ring."""
    r = (10 - clearance / 2) * 1e-3
    peg = turned([(0, 0), (r, 0), (r, 0.04), (0, 0.04)], segments)
    ring = turned([(0.01, 0), (0.02, 0), (0.02, 0.03), (0.01, 0.03)], segments)
    return scene_of({"peg": (*peg, [0, 0, 0.01]), "ring": (*ring, [0, 0, 0])})


def check_fits(binaries, folder):
    scene = folder / "peg.gltf"
    for segments, clearance, warned in [(40, 0.02, True), (104, 0.02, False), (40, 0.5, False)]:
        scene.write_text(peg_in_ring(segments, clearance))
        findings = json.loads(run(binaries, scene, "--json", "--movable", "peg",
                                  "--no-cache").stdout)["findings"]
        fits = [f for f in findings if f["code"] == "coarse-fit"]
        expect(len(fits) == int(warned), f"{segments} segments, {clearance} mm: {findings}")
        if fits:
            expect(fits[0]["where"] == "peg" and fits[0]["severity"] == "warning", f"{fits}")
            expect("at least 100 segments" in fits[0]["message"], fits[0]["message"])
    scene.write_text(peg_in_ring(40, 0.02))
    expect("at least 100 segments" in run(binaries, scene, "--movable", "peg").stdout,
           "the table does not warn")


def check_contact(binaries, folder):
    """Models of parts in the hand: none made unasked, all with --models, and from then on shown."""
    corners = [(x, y, z) for z in (-0.01, 0.01) for y in (-0.01, 0.01) for x in (-0.01, 0.01)]
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3),
             (0, 4, 6), (0, 6, 2),
             (1, 3, 7), (1, 7, 5)]
    larger = [tuple(2 * x for x in p) for p in corners]
    scene = folder / "boxes.gltf"
    scene.write_text(scene_of({"held": (corners, faces, [0, 0, 0.0301]), "base": (larger, faces, [0, 0, 0])}))

    def models(*options):
        return json.loads(run(binaries, scene, "--json", *options).stdout)["contact"]

    expect(models() == {"models": [], "missing": 0}, "nothing can be held, and yet there are models")
    none = models("--movable", "held")
    expect(none["missing"] == 2 and not list(folder.glob("tandem/*.field")),
           f"models are made unasked: {none}")
    expect("--models" in run(binaries, scene, "--movable", "held").stdout,
           "the table does not say how to get them")
    for options, source, tried in [(["--models"], "made", True), ([], "cache", False)]:
        found = models("--movable", "held", *options)
        by_part = {m["part"]: m for m in found["models"]}
        expect(found["missing"] == 0 and set(by_part) == {"held", "base"}, f"{found}")
        expect(by_part["held"]["held"] and not by_part["base"]["held"], "who can be held is told wrongly")
        for m in by_part.values():
            expect(m["bake_from"] == source and m["samples"] > 100 and m["memory_bytes"] > 0, f"{m}")
            expect(0 < m["error_m"] <= m["tolerance_m"] < 1e-5 and m["meets_tolerance"]
                   and m["sag_m"] == 0.0, f"{m}")
            expect(m["tolerance_from"] == "default" and m["clearance_to"] is None,
                   f"100 um are too far to matter: {m}")
        cost = by_part["held"]["cost_us"]
        expect((cost is not None and cost["p99"] >= cost["p50"] > 0) == tried, f"cost {cost}")
        expect(by_part["base"]["cost_us"] is None, "a part that nobody holds has a cost")
    table = run(binaries, scene, "--movable", "held").stdout
    expect("contact of parts in the hand" in table and ", cache" in table, "the table shows no models")


def check_shapes(binaries, folder):
    """Implicit shapes are exact and need nothing made; a mesh beside them has its field."""
    corners = [(x, y, z) for z in (-0.01, 0.01) for y in (-0.01, 0.01) for x in (-0.012, 0.012)]
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3),
             (0, 4, 6), (0, 6, 2),
             (1, 3, 7), (1, 7, 5)]
    gltf = json.loads(scene_of({"cube": (corners, faces, [0, 0, 0])}))
    gltf["extensionsUsed"] = ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"]
    gltf["extensions"] = {"KHR_implicit_shapes": {"shapes": [{"type": "sphere", "sphere": {"radius": 0.01}}]}}
    gltf["nodes"].append({"name": "ball", "translation": [0, 0, 0.0205],
                          "extensions": {"KHR_physics_rigid_bodies": {
        "motion": {"mass": 0.03}, "collider": {"geometry": {"shape": 0}}}}})
    gltf["scenes"][0]["nodes"].append(1)
    scene = folder / "shapes.gltf"
    scene.write_text(json.dumps(gltf))
    options = ("--json", "--movable", "cube")
    for more, missing in [((), 1), (("--models",), 0)]:
        contact = json.loads(run(binaries, scene, *options, *more).stdout)["contact"]
        models = {m["part"]: m for m in contact["models"]}
        expect(contact["missing"] == missing, f"only the cube needs a field: {contact}")
        ball = models["ball"]
        expect(ball["model"] == "exact, by formula" and ball["bake_from"] == "formula", f"{ball}")
        expect(ball["error_m"] < 1e-15 and ball["sag_m"] == 0 and ball["cells"] == 0
               and ball["meets_tolerance"], f"{ball}")
    expect(models["cube"]["model"] == "field + samples" and models["cube"]["cells"] > 0, f"{models}")
    expect("exact, by formula" in run(binaries, scene, *options[1:]).stdout,
           "the table does not tell of formulas")


def check_tolerances(binaries, folder):
    """Where a tolerance comes from: the smallest clearance, or the file."""
    scene = folder / "ring.gltf"
    # 5 um between a peg and its ring, less what 104 segments lie within the round.
    gltf = json.loads(peg_in_ring(104, 0.01))
    for given in (None, 3e-6):
        if given:
            gltf["nodes"][0]["extras"] = {"haptic": {"tolerance": given}}
        scene.write_text(json.dumps(gltf))
        models = json.loads(run(binaries, scene, "--json", "--movable", "peg",
                                "--models").stdout)["contact"]["models"]
        peg, ring = ({m["part"]: m for m in models}[name] for name in ("peg", "ring"))
        clearance = 5e-6 * math.cos(math.pi / 104)
        expect(ring["tolerance_from"] == "clearance" and ring["clearance_to"] == "peg", f"{ring}")
        expect(abs(ring["clearance_m"] - clearance) < 2e-9, f"{ring}")
        expect(abs(ring["tolerance_m"] - ring["clearance_m"] / 8) < 1e-12, f"{ring}")
        expect(peg["tolerance_from"] == ("given" if given else "clearance"), f"{peg}")
        expect(peg["tolerance_m"] == (given or ring["tolerance_m"]), f"{peg}")
    table = run(binaries, scene, "--movable", "peg").stdout
    expect("given" in table and "um to peg" in table, "the table does not tell where tolerances come from")
    gltf["nodes"][0]["extras"] = {"haptic": {"tolerance": 0}}
    scene.write_text(json.dumps(gltf))
    refused = run(binaries, scene, "--movable", "peg")
    expect(refused.returncode != 0 and "extras.haptic.tolerance: is 0 m" in refused.stderr, refused.stderr)


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        check_fits(binaries, pathlib.Path(folder))
        check_contact(binaries, pathlib.Path(folder))
        check_shapes(binaries, pathlib.Path(folder))
        check_tolerances(binaries, pathlib.Path(folder))
    return report()


if __name__ == "__main__":
    sys.exit(main())
