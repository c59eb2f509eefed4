"""What the tests of commands share: the sample scenes, where the commands are, `tandem check`, and what was
expected in vain."""
import argparse
import base64
import json
import pathlib
import struct
import subprocess

SCENES = pathlib.Path(__file__).resolve().parent.parent.parent / "assets" / "scenes"
failed = []


def expect(true, what):
    if not true:
        failed.append(what)


def run(binaries, *arguments):
    return subprocess.run([binaries / "tandem", "check", *arguments], capture_output=True, text=True)


def scene_of(parts):
    """A glTF file of named parts, each (points, triangles, place), m."""
    blob, views, accessors = b"", [], []

    def add(data, kind, component, count, **more):
        nonlocal blob
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count,
                          "type": kind, **more})
        blob += data
        return len(accessors) - 1

    nodes, meshes = [], []
    for name, (points, triangles, place) in parts.items():
        box = {"min": [min(p[i] for p in points) for i in range(3)],
               "max": [max(p[i] for p in points) for i in range(3)]}
        position = add(b"".join(struct.pack("<3f", *p) for p in points), "VEC3", 5126, len(points), **box)
        indices = add(b"".join(struct.pack("<3I", *t) for t in triangles), "SCALAR", 5125, 3 * len(triangles))
        meshes.append({"primitives": [{"attributes": {"POSITION": position}, "indices": indices}]})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": place})
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}]})


def binaries_of_command_line():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    return parser.parse_args().bin


def report():
    """Prints what failed; the exit code."""
    for what in failed:
        print("FAILED:", what)
    return 1 if failed else 0
