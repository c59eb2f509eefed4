#!/usr/bin/env python3
"""tandem probe pushes a box onto a plate: contact log, impulse, work and swept poses against what a spring
gives.

    python3 tests/end_to_end/probe_parts_test.py --bin build/release/bin
"""
import base64
import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

from check_command import binaries_of_command_line, expect, failed, report

STIFFNESS, DEPTH, GAP = 1000.0, 0.001, 0.001  # N/m, m, m
SPEED, HOLD = 0.004, 0.2  # m/s, s
BESIDE = 0.003  # m, from the box to the post


def scene():
    """A box of 20 mm that stands GAP above a plate, and a post beside it; z is up."""
    corners = [(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
    faces = [0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4,
             5, 7, 4, 7, 6]
    parts = {"box": ((0.02, 0.02, 0.02), (0, 0, 0.01 + GAP)), "plate": ((0.06, 0.06, 0.01), (0, 0, -0.005)),
             "post, tall": ((0.01, 0.01, 0.05), (0.015 + BESIDE, 0, 0.025 + 0.0002))}
    data, views, accessors, meshes, nodes = b"", [], [], [], []
    for i, (name, (size, at)) in enumerate(parts.items()):
        points = b"".join(struct.pack("<3f", *(c * s for c, s in zip(corner, size))) for corner in corners)
        indices = b"".join(struct.pack("<I", f) for f in faces)
        for blob, kind, count, component in ((points, "VEC3", 8, 5126), (indices, "SCALAR", 36, 5125)):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(blob)})
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count,
                              "type": kind})
            data += blob
        meshes.append({"primitives": [{"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1}]})
        nodes.append({"name": name, "mesh": i, "translation": at})
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
                       "nodes": nodes,
                       "meshes": meshes, "accessors": accessors, "bufferViews": views,
                       "buffers": [{"byteLength": len(data), "uri": uri}]})


def probe(binaries, folder, *arguments):
    path = [] if "--path" in arguments else ["--path", folder / "path.csv"]
    return subprocess.run([binaries / "tandem", "probe", folder / "scene.gltf", "--movable", "box", *path,
                           *arguments],
                          capture_output=True, text=True)


def near(value, expected, share):
    return abs(value - expected) <= share * abs(expected)


def check_contacts(folder, summary):
    down = DEPTH / SPEED
    impulse = STIFFNESS * DEPTH * (0.5 * down + HOLD)
    work = 0.5 * STIFFNESS * DEPTH ** 2
    contact = summary["contact"]
    print(contact)
    expect(len(contact["parts"]) == 1, f"touched: {contact['parts']}")
    plate = contact["parts"][0]
    expect(plate["part"] == "plate", f"{plate}")
    expect(near(plate["impulse_ns"], impulse, 0.02), f"impulse {plate['impulse_ns']}, not {impulse}")
    expect(near(plate["largest_force_n"], STIFFNESS * DEPTH, 0.02), f"force {plate}")
    expect(near(plate["ticks"], 1000 * (down + HOLD), 0.02), f"ticks {plate}")
    expect(near(contact["work_j"], work, 0.02), f"work {contact['work_j']}, not {work}")
    expect(near(contact["work_in_contact_j"], work, 0.02), f"work in contact {contact}")
    with open(folder / "contacts.csv") as file:
        rows = list(csv.DictReader(file))
    expect({row["part"] for row in rows} == {"plate"}, "the log names another part")
    expect(all(abs(float(row["nz"]) - 1) < 1e-6 and abs(float(row["pz"])) < 5e-6 for row in rows),
           "normals, places")
    expect(near(sum(float(row["force"]) for row in rows) * 1e-3, plate["impulse_ns"], 1e-6),
           "log and sum differ")


def check_swept(folder, summary):
    with open(folder / "swept.csv") as file:
        rows = list(csv.DictReader(file))
    expect(len(rows) == summary["swept"]["poses"] and 5 <= len(rows) <= 7,
           f"{len(rows)} poses for 1 mm by 0.2 mm")
    expect(abs(float(rows[0]["z"]) - 0.01 - GAP) < 1e-6, f"{rows[0]}")
    for before, row in zip(rows, rows[1:]):
        expect(0.0002 <= float(before["z"]) - float(row["z"]) < 0.00021, f"{row}")
    for row in rows:
        expect(abs(float(row["clearance:plate"]) - float(row["z"]) + 0.01) < 1e-6, f"{row}")
        expect(abs(float(row["clearance:post, tall"]) - BESIDE) < 1e-5, f"{row}")
    expect(summary["swept"]["least_clearance_to"] == "plate", f"{summary['swept']}")


def check_two_hands(binaries, folder):
    """Both hands at the box, in the air: what pulls it apart is felt by both, as two springs in series."""
    apart, pulling = 0.002, 200
    for name, sign in (("first", -1), ("second", 1)):
        with open(folder / f"{name}.csv", "w") as path:
            path.write("t,x,y,z\n")
            for i in range(3 * pulling):
                x = sign * (0.01 + apart * min(i / pulling, 1))
                path.write(f"{i * 1e-3:.3f},{x:.9f},0,{0.01 + GAP:.9f}\n")
    result = probe(binaries, folder, "--tool", "part:box", "--path", folder / "first.csv", "--second-path",
                   folder / "second.csv", "--stiffness", str(STIFFNESS), "--ticks", folder / "ticks.csv")
    expect(result.returncode == 0, result.stderr)
    expect("second hand: largest force 2" in result.stdout, result.stdout)
    with open(folder / "ticks.csv") as file:
        rows = list(csv.DictReader(file))
    expect(list(rows[0])[-6:] == ["f2x", "f2y", "f2z", "t2x", "t2y", "t2z"], f"{list(rows[0])}")
    expect(float(rows[0]["fx"]) == 0 and float(rows[0]["f2x"]) == 0, f"{rows[0]}")
    expect(near(float(rows[-1]["fx"]), STIFFNESS * apart, 1e-3), f"{rows[-1]}")
    expect(near(float(rows[-1]["f2x"]), -STIFFNESS * apart, 1e-3), f"{rows[-1]}")


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "scene.gltf").write_text(scene())
        steps = round((GAP + DEPTH) / SPEED * 1000)
        with open(folder / "path.csv", "w") as path:
            path.write("t,x,y,z\n")
            for i in range(steps + round(1000 * HOLD) + 1):
                path.write(f"{i * 1e-3:.3f},0,0,{0.01 + GAP - SPEED * 1e-3 * min(i, steps):.9f}\n")
        result = probe(binaries, folder, "--tool", "part:box", "--stiffness", str(STIFFNESS), "--damping",
                       "0",
                       "--contacts", folder / "contacts.csv", "--swept", folder / "swept.csv",
                       "--swept-step", "0.0002",
                       "--json", folder / "probe.json")
        expect(result.returncode == 0, result.stderr)
        expect("touched plate in" in result.stdout and "least clearance" in result.stdout, result.stdout)
        if not failed:
            summary = json.loads((folder / "probe.json").read_text())
            check_contacts(folder, summary)
            check_swept(folder, summary)
        check_two_hands(binaries, folder)
        for option in ("--contacts", "--swept", "--second-path"):
            result = probe(binaries, folder, option, folder / "none.csv")
            expect(result.returncode == 2 and " --tool part:NAME" in result.stderr,
                   f"{option}: {result.stderr}")
            expect(len(result.stderr.strip().splitlines()) == 1, result.stderr)
    return report()


if __name__ == "__main__":
    sys.exit(main())
