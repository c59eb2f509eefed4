#!/usr/bin/env python3
"""Shows whether a rebuilt Tandem gives the same results as before, to the bit.

    python3 tests/same_results.py record --bin build/release/bin -o before.json [--data DIR] [--seeds 3]
      [--quick]
    python3 tests/same_results.py compare before.json after.json
    python3 tests/same_results.py benches --a BIN --b BIN [--runs 5] [--data DIR]

`record` keeps: the hash of every scenario in tests/simulation/scenarios with each seed; the ticks of `tandem
probe` with a point, a ball and every movable part of every sample scene along a seeded path; `tandem check
--json` of the sample scenes and of the engine in --data. Times are left out. `compare` exits with 1 and names
each result that differs, with the largest difference of each column of ticks. `benches` runs the benches of
two builds in turn, as ratios to their yardsticks, and prints the medians and what B differs from A in per
cent.
"""
import argparse
import concurrent.futures
import csv
import hashlib
import json
import math
import os
import pathlib
import random
import re
import statistics
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENARIOS = sorted((ROOT / "tests/simulation/scenarios").glob("*.json"))
SCENES = sorted((ROOT / "assets/scenes").glob("*.glb"))
TIMES = re.compile(r"(^|_)(us|ns|ms)$|^p50$|^p99$|^p999$|^max$|seconds|^bake_s$")
# What was measured, two blanks or more, its figures. A row indented further belongs to the one above it.
BENCH_ROW = re.compile(r"(  +)(\S.*?)  +(?=\S*\d|p50)(.*)")
NUMBER = re.compile(r"(?<![\w.])\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])")
TICKS_S, STROKES_MM = 1.5, (25.0, 8.0)  # how long a path is; how far a tool and a part are led


def gltf_nodes(scene):
    """The nodes of a binary glTF as name -> (position, quaternion wxyz), world; scales are left out."""
    data = scene.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + length])
    placed = {}

    def multiply(a, b):
        w, x, y, z = a
        s, u, v, t = b
        return (w * s - x * u - y * v - z * t, w * u + x * s + y * t - z * v,
                w * v - x * t + y * s + z * u, w * t + x * v - y * u + z * s)

    def rotate(q, point):
        w, x, y, z = multiply(multiply(q, (0.0, *point)), (q[0], -q[1], -q[2], -q[3]))
        return x, y, z

    def visit(index, at, turned):
        node = document["nodes"][index]
        x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
        at = tuple(a + b for a, b in zip(at, rotate(turned, node.get("translation", (0.0, 0.0, 0.0)))))
        turned = multiply(turned, (w, x, y, z))
        placed[node.get("name", str(index))] = (at, turned)
        for child in node.get("children", ()):
            visit(child, at, turned)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    return placed


def write_path(file, start, orientation, reach, seed):
    """A smooth path of TICKS_S from `start`: three sines an axis, `reach` m far; a part also turns by up to
    0.2 rad."""
    draw = random.Random(seed)
    waves = [[(draw.uniform(0.3, 1.0), draw.uniform(0.5, 3.0)) for _ in range(3)] for _ in range(4)]

    def wave(axis, t):
        return sum(a * math.sin(2.0 * math.pi * f * t) for a, f in waves[axis]) / 3.0

    with open(file, "w", encoding="utf-8") as out:
        out.write("t,x,y,z,qw,qx,qy,qz\n" if orientation else "t,x,y,z\n")
        for i in range(int(TICKS_S * 1000)):
            t = i / 1000.0
            row = [t] + [s + reach * wave(axis, t) for axis, s in enumerate(start)]
            if orientation:
                half = 0.1 * wave(3, t)
                w, x, y, z = orientation
                c, s = math.cos(half), math.sin(half)  # about the world's z
                row += [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
            out.write(",".join(repr(value) for value in row) + "\n")


def run(command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(map(str, command))}: exit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if not TIMES.search(k)}
    if isinstance(value, list):
        return [without_times(v) for v in value]
    return value


def ticks(binaries, scene, tool, reach, cache):
    """The columns of `probe --ticks`, without the time that ticks took, as name -> list of the cells'
    texts."""
    nodes = gltf_nodes(scene)
    name = tool.split(":", 1)[1] if tool.startswith("part:") else sorted(nodes)[len(nodes) // 2]
    start, orientation = nodes[name]
    seed = int.from_bytes(hashlib.sha256(f"{scene.name} {tool}".encode()).digest()[:4], "little")
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder) / "path.csv", pathlib.Path(folder) / "ticks.csv"
        write_path(path, start, orientation if tool.startswith("part:") else None, reach, seed)
        run([binaries / "tandem", "probe", scene, "--path", path, "--tool", tool, "--ticks", out],
            env={**os.environ, "XDG_CACHE_HOME": cache})
        with open(out, encoding="utf-8", newline="") as rows:
            table = list(csv.reader(rows))
    header, rows = table[0], table[1:]
    return {column: [row[i] for row in rows] for i, column in enumerate(header) if column != "compute_ns"}


def record(options):
    binaries = pathlib.Path(options.bin)
    result = {"scenarios": {}, "ticks": {}, "checks": {}}
    with (tempfile.TemporaryDirectory() as cache,
          concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool):
        jobs = {}
        for scene in SCENES + ([pathlib.Path(options.data) / "2CylinderEngine.glb"] if options.data else []):
            jobs["checks", scene.name] = pool.submit(lambda s: without_times(json.loads(run(
                [binaries / "tandem", "check", s, "--json"],
                env={**os.environ, "XDG_CACHE_HOME": cache}))), scene)
        for scene in SCENES:
            movable = [part["name"] for part in jobs["checks", scene.name].result()["parts"]
                       if part["movable"]]
            # The first run of a scene bakes its models; those that follow read them.
            tools = ["point", "ball:0.002"] + [f"part:{name}" for name in movable]
            for tool in tools[:1] if options.quick else tools:
                reach = STROKES_MM[tool.startswith("part:")] / 1000.0
                jobs["ticks", f"{scene.name} {tool}"] = pool.submit(ticks, binaries, scene, tool, reach,
                                                                    cache)
        for scenario in SCENARIOS[:2] if options.quick else SCENARIOS:
            for seed in range(1, options.seeds + 1):
                jobs["scenarios", f"{scenario.stem} {seed}"] = pool.submit(lambda s, n: re.search(
                    r"hash ([0-9a-f]+)", run([binaries / "tandem", "simulate", s, "--seed", n])).group(1),
                                                                           scenario, seed)
        for done, ((kind, name), job) in enumerate(jobs.items(), 1):
            result[kind][name] = job.result()
            print(f"\r{done} of {len(jobs)}  {kind} {name:60}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    pathlib.Path(options.output).write_text(json.dumps(result), encoding="utf-8")


def differences(kind, name, before, after):
    if kind != "ticks":
        if before == after:
            return ""
        return f"{kind} {name}: {json.dumps(before)[:300]} became {json.dumps(after)[:300]}"
    if list(before) != list(after):
        return f"ticks {name}: columns {list(before)} became {list(after)}"
    worst = {}
    for column, cells in before.items():
        changed = [(a, b) for a, b in zip(cells, after[column]) if a != b]
        if changed or len(cells) != len(after[column]):
            try:
                worst[column] = max(abs(float(a) - float(b)) for a, b in changed)
            except ValueError:
                worst[column] = math.nan
    return f"ticks {name}: largest differences {worst}" if worst else ""


def compare(options):
    before, after = (json.loads(pathlib.Path(p).read_text(encoding="utf-8"))
                     for p in (options.before, options.after))
    found, count = [], 0
    for kind in before:
        for name in sorted(set(before[kind]) | set(after[kind])):
            count += 1
            if name not in before[kind] or name not in after[kind]:
                found.append(f"{kind} {name}: only in one of the two")
            else:
                found.append(differences(kind, name, before[kind][name], after[kind][name]))
    found = [line for line in found if line]
    print("\n".join(found))
    print(f"{count} results, {len(found)} differ")
    return 1 if found or count == 0 else 0


def benches(options):
    engine = [str(pathlib.Path(options.data) / "2CylinderEngine.glb")] if options.data else []
    figures = {}
    for _ in range(options.runs):
        for side, folder in (("a", options.a), ("b", options.b)):
            for bench, arguments in (("bench_tick", engine), ("bench_contact", []), ("bench_load", engine)):
                above = ""
                for line in run([pathlib.Path(folder) / bench, *arguments]).splitlines():
                    row = BENCH_ROW.match(line)
                    numbers = NUMBER.findall(row.group(3)) if row else []
                    if not numbers:
                        continue
                    if len(row.group(1)) == 2:
                        above = row.group(2)
                    what = row.group(2) if len(row.group(1)) == 2 else f"{above}, {row.group(2)}"
                    figures.setdefault((bench, what), {"a": [], "b": []})[side].append(
                        [float(n) for n in numbers])
    for (bench, what), sides in figures.items():
        columns = zip(zip(*sides["a"]), zip(*sides["b"]))
        cells = []
        for a, b in columns:
            left, right = statistics.median(a), statistics.median(b)
            cells.append(f"{left:g} -> {right:g}"
                         + (f" ({100.0 * (right / left - 1.0):+.1f} %)" if left else ""))
        print(f"{bench} {what}: " + ", ".join(cells))
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("record")
    one.add_argument("--bin", required=True)
    one.add_argument("-o", "--output", required=True)
    one.add_argument("--data")
    one.add_argument("--seeds", type=int, default=3)
    one.add_argument("--quick", action="store_true", help="two scenarios, and points only")
    one.set_defaults(do=record)
    two = commands.add_parser("compare")
    two.add_argument("before")
    two.add_argument("after")
    two.set_defaults(do=compare)
    three = commands.add_parser("benches")
    three.add_argument("--a", required=True)
    three.add_argument("--b", required=True)
    three.add_argument("--runs", type=int, default=5)
    three.add_argument("--data")
    three.set_defaults(do=benches)
    options = parser.parse_args()
    return options.do(options)


if __name__ == "__main__":
    sys.exit(main())
