#!/usr/bin/env python3
"""tandem-import: assemblies with a known answer, real files, damaged files, and what no program may link.

    python3 tests/end_to_end/import_test.py --bin build/release/bin

Validates every result by the Khronos glTF validator where npm can fetch that; TANDEM_FULL_SIZE damages a
thousand files, and imports a thousand parts.
"""
import collections
import json
import os
import pathlib
import random
import re
import resource
import shutil
import struct
import subprocess
import tempfile

from check_command import binaries_of_command_line, expect, report

ROOT = pathlib.Path(__file__).resolve().parents[2]
FULL = bool(os.environ.get("TANDEM_FULL_SIZE"))
VALIDATE = """const fs = require('fs'), v = require('gltf-validator');
const file = new Uint8Array(fs.readFileSync(process.argv[1]));
v.validateBytes(file).then(r => console.log(JSON.stringify(r.issues)));"""


class Importer:
    def __init__(self, binaries, folder):
        self.binaries, self.folder = binaries, folder
        self.npm = self.fetch_validator()

    def fetch_validator(self):
        """A folder with the validator, kept beside the build; None without npm or a network."""
        folder = self.binaries.resolve().parent / "gltf-validator"
        if not (folder / "node_modules" / "gltf-validator").exists():
            if not shutil.which("npm"):
                print("skipped: npm is not there, results are not validated")
                return None
            folder.mkdir(exist_ok=True)
            done = subprocess.run(["npm", "install", "--prefix", folder, "gltf-validator"],
                                  capture_output=True, timeout=100)
            if done.returncode != 0:
                print("skipped: npm cannot fetch gltf-validator, results are not validated")
                return None
        return folder

    def run(self, file, *options):
        out = self.folder / "out.glb"
        return subprocess.run([self.binaries / "tandem-import", file, "-o", out, *options],
                              capture_output=True, text=True), out

    def scene(self, file, *options):
        """The report and the glTF JSON of a file that must be taken."""
        done, out = self.run(file, "--json", *options)
        expect(done.returncode == 0 and done.stderr == "", f"{file.name}: {done.returncode} {done.stderr}")
        if self.npm:
            issues = json.loads(subprocess.run(["node", "-e", VALIDATE, out], cwd=self.npm, check=True,
                                               capture_output=True, text=True).stdout)
            expect(issues["numErrors"] == 0, f"{file.name}: {issues}")
        data = out.read_bytes()
        return json.loads(done.stdout), json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])

    def clashes(self):
        tandem = self.binaries / "tandem"
        done = subprocess.run([tandem, "check", self.folder / "out.glb", "--clash", "--json"],
                              capture_output=True, text=True, check=True)
        return json.loads(done.stdout)["clashes"]

    def make(self, case, unit="MM"):
        path = self.folder / f"{case}_{unit}.step"
        subprocess.run([self.binaries / "make_step", case, path, unit], check=True, capture_output=True)
        return path


def codes(told):
    return {finding["code"]: finding["count"] for finding in told["findings"]}


def check_fixture(importer):
    told, scene = importer.scene(importer.make("fixture"))
    expect((told["parts"], told["meshes"], told["fits"]) == (3, 2, 2), f"fixture: {told}")
    expect(codes(told) == {"construction-shells": 1}, f"fixture: {told['findings']}")
    expect(told["exact_faces"]["cylinder"] == 3, f"fixture: {told['exact_faces']}")
    names = [node.get("name") for node in scene["nodes"] if "mesh" in node]
    expect(names == ["housing", "left pin", "pin"], f"fixture: {names}")
    pins = [node for node in scene["nodes"] if node.get("name") in ("left pin", "pin")]
    expect(pins[0]["mesh"] == pins[1]["mesh"], "fixture: the pins share no mesh")
    cad = pins[0].get("extras", {}).get("cad", {})
    expect(cad.get("material") == "Steel" and abs(cad.get("density", 0) - 7850) < 1e-6, f"fixture: {cad}")
    mesh = scene["meshes"][pins[0]["mesh"]]
    colour = scene["materials"][mesh["primitives"][0]["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
    expect(colour[0] > 0.99 and colour[1] < 0.01, f"fixture: {colour}")
    shaft = [face for face in mesh["extras"]["cad"]["faces"] if face["kind"] == "cylinder"][0]
    expect(abs(shaft["radius"] - 0.005) < 1e-12 and not shaft["hollow"], f"fixture: {shaft}")
    expect(abs(shaft["to"] - shaft["from"] - 0.04) < 1e-12, f"fixture: {shaft}")
    bores = [face for face in scene["meshes"][1 - pins[0]["mesh"]]["extras"]["cad"]["faces"]
             if face["kind"] == "cylinder"]
    expect(len(bores) == 2 and all(face["hollow"] for face in bores), f"fixture: {bores}")
    expect(importer.clashes()["hard"] == 0, "fixture: facets of the fits overlap")
    importer.scene(importer.make("oversize"))
    deepest = max(found["depth_m"] for found in importer.clashes()["found"])
    # Their facets stand up to 25 um off the round.
    expect(0.00009 < deepest < 0.00013, f"oversize: pins 0.1 mm too thick are {deepest} m deep")


def check_tolerances(importer):
    """What the file states of a part stands beside it in the import's report and in `tandem check`."""
    step = importer.make("toleranced")
    told, _ = importer.scene(step)
    stated = {(each["part"], each["said"]) for each in told["tolerances"]}
    pin = ("diameter 10 mm +0.018 -0.002", "cylindricity 0.01 mm")
    expected = {(name, words) for name in ("left pin", "pin") for words in pin}
    expected.add(("housing", "flatness 0.05 mm"))
    expect(stated == expected, f"tolerances: {stated}")
    done = subprocess.run([importer.binaries / "tandem", "check", step], capture_output=True, text=True,
                          env={**os.environ, "XDG_CACHE_HOME": str(importer.folder / "tolerances")})
    lines = {line for line in done.stdout.splitlines() if line.startswith("tolerance ")}
    expect(lines == {f"tolerance {name}: {words}" for name, words in expected},
           f"tolerances: {done.returncode} {lines} {done.stderr}")


def check_bearing(importer):
    """The scene of `client/demo review` is what make_step writes, and its script names parts that it has."""
    def solids(path):  # in no order: the writer's own differs from run to run
        return sorted(re.findall(r"(?:CARTESIAN_POINT|DIRECTION|PRODUCT)\(.*", path.read_text()))
    committed = ROOT / "assets/scenes/bearing.step"
    expect(solids(importer.make("bearing")) == solids(committed), "bearing: not what make_step writes")
    told, scene = importer.scene(committed)
    expect((told["parts"], told["meshes"]) == (8, 6), f"bearing: {told}")
    hard = [(found["a"], found["b"]) for found in importer.clashes()["found"] if found["kind"] == "overlap"]
    expect(hard == [("base", "bolt 4")], f"bearing: {hard}")
    names = {node.get("name") for node in scene["nodes"]}
    script = json.loads((ROOT / "client/demo_hands/review.json").read_text())
    named = {step["part"] for step in script if "part" in step}
    named |= {name for step in script for name in step.get("parts", [])}
    expect(named and named <= names, f"bearing: no part is called {named - names}")


def extent(scene):
    return [accessor["max"] for accessor in scene["accessors"] if "max" in accessor]


def check_units(importer):
    plain = extent(importer.scene(importer.make("fixture"))[1])
    for unit in ("INCH", "M"):
        other = extent(importer.scene(importer.make("fixture", unit))[1])
        off = max(abs(a - b) for x, y in zip(plain, other) for a, b in zip(x, y))
        expect(off < 1e-7, f"{unit}: {off} m off the same file in mm")
    told, scene = importer.scene(importer.make("fixture"), "--units", "inch")
    off = max(abs(25.4 * a - b) for x, y in zip(plain, extent(scene)) for a, b in zip(x, y))
    expect(off < 1e-6 and told["unit"] == "inch", f"--units inch: {off} m off")
    told, _ = importer.scene(importer.make("fixture"), "--units", "m")
    said = [finding["message"] for finding in told["findings"] if finding["code"] == "unit-doubt"]
    expect(len(said) == 1 and "--units mm" in said[0], f"60 m of fixture: {said}")


def check_meshes(importer):
    points = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    coordinates = "".join(f"property float {axis}\n" for axis in "xyz")
    texts = {"obj": "".join("v %g %g %g\n" % p for p in points) +
                    "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces),
             "ply": "ply\nformat ascii 1.0\nelement vertex 4\n" + coordinates +
                    "element face 4\nproperty list uchar int vertex_indices\nend_header\n" +
                    "".join("%g %g %g\n" % p for p in points) + "".join("3 %d %d %d\n" % f for f in faces),
             "stl": "solid x\n" + "".join(
                 "facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % points[i] for i in f) +
                 "endloop\nendfacet\n" for f in faces) + "endsolid x\n"}
    for ending, text in texts.items():
        file = importer.folder / f"corner.{ending}"
        file.write_text(text)
        told, scene = importer.scene(file, "--units", "mm")
        expect((told["parts"], told["triangles"]) == (1, 4), f"{ending}: {told}")
        expect(scene["nodes"][0]["name"] == "corner", f"{ending}: {scene['nodes']}")
        expect(max(max(high) for high in extent(scene)) == struct.unpack("<f", struct.pack("<f", 0.01))[0],
               f"{ending}: {extent(scene)}")


def refused(importer, file, word, *options):
    done, out = importer.run(file, *options)
    lines = done.stderr.splitlines()
    expect(done.returncode == 2 and len(lines) == 1 and word in lines[0] and done.stdout == "",
           f"{file} {options}: {done.returncode} {done.stderr!r}")
    expect(not out.exists() and not out.with_name("out.glb.part").exists(), f"{file}: something is left")


def check_refusals(importer):
    (importer.folder / "out.glb").unlink(missing_ok=True)
    step = importer.make("fixture")
    for name, text in (("empty.step", ""), ("text.step", "hello\n"), ("notes.txt", "x"),
                       ("bad.stl", "solid\n"),
                       ("none.step", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")):
        (importer.folder / name).write_text(text)
        refused(importer, importer.folder / name, name)
    refused(importer, importer.folder / "absent.step", "no such file")
    refused(importer, step, "--units", "--units", "parsec")
    refused(importer, step, "--deflection", "--deflection", "-1")
    refused(importer, importer.folder, "no such file")


def ended_well(importer, file, seed):
    """Imports a damaged file; whatever it holds, there is a result or one line, and nothing half."""
    done, out = importer.run(file, "--limit-seconds", "20")
    lines = done.stderr.splitlines()
    expect(done.returncode in (0, 2), f"seed {seed}: exit code {done.returncode} {done.stderr}")
    expect(len(lines) == (0 if done.returncode == 0 else 1), f"seed {seed}: {done.stderr}")
    expect(not out.with_name("out.glb.part").exists(), f"seed {seed}: half a result is left")
    return done


def check_damage(importer, files):
    """Of bytes changed at random; the program outlives its reader, and says one line or has a whole scene."""
    ends = collections.Counter()
    for seed in range(1000 if FULL else 50):
        source = files[seed % len(files)]
        draw, data = random.Random(seed), bytearray(source.read_bytes())
        for _ in range(30):
            data[draw.randrange(len(data))] = draw.randrange(256)
        file = importer.folder / "damaged.step"
        file.write_bytes(data[:draw.randrange(len(data))] if seed % 10 == 9 else data)
        done = ended_well(importer, file, seed)
        ends[done.returncode, "crashed" in done.stderr] += 1
    expect(sum(number for (code, crashed), number in ends.items() if crashed) > 0,
           f"no reader crashed, so nothing was shown: {ends}")
    print("damaged files:", dict(ends))


def check_links(importer, library="libTK"):
    """The importer alone is linked with what reads CAD files."""
    for program, wanted in (("tandem", False), ("tandem-server", False), ("tandem-import", True)):
        listed = subprocess.run(["ldd", importer.binaries / program],
                                capture_output=True, text=True, check=True)
        expect((library in listed.stdout) == wanted, f"{program} links {library}: {not wanted}")


def check_server(importer):
    """tandem-server takes a STEP file itself, refuses a damaged one in a line, and finds the scene again."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(importer.folder / "cache")}

    def serve(file, *options):
        command = [importer.binaries / "tandem-server", file, "--listen", "127.0.0.1:0", "--duration", "0.2",
                   "--movable", "all", "--data", importer.folder / "data", *options]
        return subprocess.run(command, capture_output=True, text=True, env=environment)

    step = importer.make("fixture")  # which holds the time of its making
    for _ in range(2):
        done = serve(step)
        expect(done.returncode == 0 and "3 parts (3 movable)" in done.stderr, f"server: {done.stderr}")
        expect("onstruction" in done.stderr, f"server: does not say what the import found: {done.stderr}")
    cached = list((importer.folder / "cache" / "tandem").glob("import-*/*.glb"))
    expect(len(cached) == 1, f"server: cached imports: {cached}")
    bad = importer.folder / "text.step"
    bad.write_text("hello\n")
    done = serve(bad)
    lines = done.stderr.splitlines()
    expect(done.returncode == 2 and len(lines) == 1 and "text.step" in lines[0], f"server: {done.stderr!r}")


def check_commands(importer):
    """The commands of tandem take a STEP file as tandem-server does, and share its cache."""
    folder = importer.folder / "commands"
    temporary = folder / "tmp"
    temporary.mkdir(parents=True)
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache"), "TMPDIR": str(temporary)}

    def run(*arguments, program=importer.binaries / "tandem", **more):
        return subprocess.run([program, *arguments], capture_output=True, text=True,
                              env={**environment, **more})

    def refused(done, *words):
        lines = done.stderr.splitlines()
        expect(done.returncode == 2 and len(lines) == 1 and all(word in lines[0] for word in words),
               f"commands: {done.returncode} {done.stderr!r}")

    step = importer.make("fixture")
    _, glb = importer.run(step)
    of_glb = json.loads(run("check", glb, "--json").stdout)
    for options in ((), (), ("--no-cache",)):
        done = run("check", step, "--json", *options)
        expect(done.returncode == 0 and done.stderr == "", f"check: {done.returncode} {done.stderr}")
        parts = json.loads(done.stdout)["parts"]
        names = [part["name"] for part in parts]
        expect(names == [part["name"] for part in of_glb["parts"]], f"check: {parts}")
        imports = list((folder / "cache" / "tandem").glob("import-*/*.glb"))
        expect([file.name for file in imports] == ["fixture_MM.glb"], f"check: cached imports: {imports}")
    said = {found["code"]: found["count"] for found in json.loads(done.stdout)["findings"]}
    expect(said.get("import-construction-shells") == 1, f"check: {said}")
    expect(not list(temporary.iterdir()), "check --no-cache leaves files behind")
    done = run("extract", step, "--part", "left pin", "--movable", "left pin", "--json", folder / "out.json")
    expect(done.returncode == 0, f"extract: {done.returncode} {done.stdout} {done.stderr}")
    (folder / "path.csv").write_text("t,x,y,z\n0,0.2,0.2,0.2\n0.01,0.2,0.2,0.2\n")
    done = run("probe", step, "--path", folder / "path.csv")
    expect(done.returncode == 0, f"probe: {done.returncode} {done.stderr}")
    bad = importer.folder / "text.step"
    bad.write_text("hello\n")
    refused(run("check", bad), "text.step")
    refused(run("check", folder / "none.step"), "none.step", "cannot be read")
    alone = folder / "bin" / "tandem"
    alone.parent.mkdir()
    shutil.copy(importer.binaries / "tandem", alone)
    refused(run("check", step, "--no-cache", program=alone, PATH=str(alone.parent)), "fixture_MM.step",
            "tandem-import", ".ci/install import")


def check_real_files(importer, folder):
    """as1-oc-214 has its round faces as splines."""
    for file in sorted(folder.glob("*.st*p")):
        told, _ = importer.scene(file)
        print(f"{file.name}: {told['parts']} parts of {told['meshes']} meshes, "
              f"{told['triangles']} triangles; "
              f"reading {told['reading_s']:.2f} s, the rest {told['meshing_s']:.2f} s")
        if file.name == "as1-oc-214.stp":
            expect((told["parts"], told["meshes"], told["fits"]) == (18, 5, 22), f"{file.name}: {told}")
            clashes = importer.clashes()
            expect(clashes["hard"] == 0 and clashes["touches"] == 32,
                   f"{file.name}: {clashes['hard']} overlaps")


def check_thousand(importer):
    file = importer.make("thousand")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    told, _ = importer.scene(file)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = used.ru_utime - before.ru_utime
    print(f"a thousand parts: {seconds:.1f} s of the processor, at most {used.ru_maxrss / 1e6:.2f} GB; "
          f"reading {told['reading_s']:.1f} s, the rest {told['meshing_s']:.1f} s")
    expect((told["parts"], told["meshes"]) == (1000, 100), f"thousand: {told['parts']} of {told['meshes']}")


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        importer = Importer(binaries, pathlib.Path(folder))
        check_links(importer)
        check_fixture(importer)
        check_tolerances(importer)
        check_bearing(importer)
        check_units(importer)
        check_meshes(importer)
        check_refusals(importer)
        check_server(importer)
        check_commands(importer)
        files = [importer.make("fixture")]
        if data := os.environ.get("TANDEM_DATA"):
            check_real_files(importer, pathlib.Path(data))
            files += sorted(pathlib.Path(data).glob("*.st*p"))
        check_damage(importer, files)
        if FULL:
            check_thousand(importer)
    return report()


if __name__ == "__main__":
    raise SystemExit(main())
