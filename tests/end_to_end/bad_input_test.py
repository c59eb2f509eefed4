#!/usr/bin/env python3
"""Bad arguments and files given to the programs: exit code 2, and one line on standard error that says why.

    python3 tests/end_to_end/bad_input_test.py --bin build/release/bin
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from check_command import binaries_of_command_line

PUMP = str(pathlib.Path(__file__).resolve().parents[2] / "assets" / "scenes" / "pump.glb")


def scenario(folder, name, change):
    document = {"scene": PUMP, "duration_s": 0.1, "sites": [{"name": "a", "script": []}]}
    change(document)
    path = folder / f"{name}.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return str(path)


def cases(folder, binaries):
    """Pairs of a command and a word that the line must hold."""
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0,0.2\n")
    (folder / "deep.json").write_text(json.dumps({"scene": PUMP, "duration_s": 1,
                                                  "sites": [{"name": "a", "script": "?"}]})
                                      .replace('"?"', "[" * 100000 + "]" * 100000))
    probe = ["tandem", "probe", PUMP, "--path", str(folder / "path.csv")]
    yield probe + ["--stiffness", "nan"], "--stiffness"
    yield probe + ["--damping", "nan"], "--damping"
    yield probe + ["--tool", "ball:nan"], "radius"
    yield probe + ["--tool", "ball:1e308"], "radius"
    yield probe + ["--ticks", str(folder)], "directory"
    yield probe + ["--movable", "a\nb"], "movable"
    yield ["tandem", "probe", PUMP, "--path", str(folder)], "directory"
    (folder / "back.csv").write_text("t,x,y,z\n0,0,0,0.2\n0.001,0,0,0.2\n0.0005,0,0,0.2\n")
    yield ["tandem", "probe", PUMP, "--path", str(folder / "back.csv")], "line 4"
    yield probe + ["--device", "omni"], "none"
    yield probe + ["--move", "impeller=" + str(folder / "back.csv")], "line 4"
    yield ["tandem", "simulate", str(folder)], "directory"
    yield ["tandem", "simulate", str(folder / "deep.json")], "deeper"
    site = lambda **fields: lambda document: document["sites"][0].update(fields)
    yield ["tandem", "simulate", scenario(folder, "verb", site(script=[{"t": 0, "do": "a\nb"}]))], "step 1"
    yield ["tandem", "simulate", scenario(folder, "far", site(start=[1e308, 0, 0]))], "start"
    yield ["tandem", "simulate", scenario(folder, "name", site(name="x" * 65))], "name"
    yield ["tandem", "simulate", scenario(folder, "scene", lambda d: d.update(scene="a" * 9999))], "aaa"
    good = scenario(folder, "good", lambda document: None)
    yield ["tandem", "simulate", good, "--trace", str(folder)], "directory"
    yield ["tandem", "simulate", good, "--trace", "/dev/full"], "/dev/full"
    yield ["tandem", "check", PUMP, "--delay-ms", "nan"], "--delay-ms"
    yield ["tandem", "report", "--scenes", "a\nb"], "--scenes"
    yield ["tandem", "report", "--out", str(folder)], "directory"
    yield ["tandem", "report", "--quick", "--peers", str(folder / "path.csv")], "--peers"
    yield ["tandem", "join", "tandem://nonsense", "--duration", "nan"], "--duration"
    # Refused before the link is used up: nobody listens there, and nobody is asked.
    link = "tandem://127.0.0.1:1/participant?token=" + "ab" * 16 + "&pin=" + "cd" * 32
    (folder / "desk.json").write_text(json.dumps({"view_from_device": {"position": [0, 0, 0],
                                                                       "orientation_wxyz": [1, 0, 0, 0]},
                                                  "scale": 1, "residual_rms_m": 0, "residual_worst_m": 0,
                                                  "pairs": 4}))
    (folder / "jump.json").write_text(json.dumps([{"t": 0, "do": "jump"}]))
    yield ["tandem", "join", link, "--hand", str(folder / "jump.json")], "step 1"
    yield ["tandem", "join", link, "--device", "simulated", "--calibration",
           str(folder / "desk.json")], "no workspace"
    yield ["tandem", "join", link, "--device", "simulated-arm", "--calibration",
           str(folder / "none.json")], "none.json"
    yield ["tandem", "devices", "--test", "none", "--hid-record", str(folder / "no" / "r")], "--hid-record"
    (folder / "pump.step").write_text("ISO-10303-21;\nHEADER;\n")
    (folder / "pump.stl").write_bytes(bytes(84))
    (folder / "pump.fbx").write_bytes(b"Kaydara FBX Binary  ")
    (folder / "step.glb").write_text("ISO-10303-21;\nHEADER;\n")
    yield ["tandem", "check", str(folder / "step.glb")], "this is a STEP file; Tandem reads glTF"
    yield ["tandem", "check", str(folder / "pump.step")], "pump.step"
    yield ["tandem-server", str(folder / "pump.fbx")], "this is an FBX file; Tandem reads glTF"
    yield ["tandem-server", str(folder / "pump.stl")], "pump.stl"
    yield ["tandem", "chekc", PUMP], "unknown command chekc; did you mean check?"
    yield ["tandem", "assemble", PUMP], "unknown command assemble"
    yield probe + ["--tool", "part:impelle"], "near it are 'impeller'"
    yield probe + ["--move", "impelle=" + str(folder / "path.csv")], "near it are 'impeller'"
    yield ["tandem", "check", PUMP, "--distance", "impeller", "shft"], "'shaft"
    yield ["tandem-server", PUMP, "--lease-ms", "nan"], "--lease-ms"
    yield ["tandem-server", PUMP, "--duration", "nan"], "--duration"
    yield ["tandem-server", "a\nb.glb"], "a_b.glb"
    yield ["tandem-server", PUMP, "--gravity", "1e308,0,0"], "--gravity"
    yield ["tandem-server", PUMP, "--link-host", "a b\nc"], "--link-host"
    for url in ("file:///etc/passwd", "https://a\x1b[2J", "https://a.org/" + 300 * "x", "meet.example.org"):
        yield ["tandem-server", PUMP, "--voice-url", url], "--voice-url"
    data = folder / "data"
    serve = ["tandem-server", PUMP, "--listen", "127.0.0.1:0", "--duration", "0.1"]
    recording = str(folder / "nobody.rec")
    subprocess.run([binaries / serve[0], *serve[1:], "--data", data, "--record", recording],
                   capture_output=True, timeout=240,
                   check=True)
    yield ["tandem", "replay", recording, "--scene", PUMP, "--headless", "--at", "99"], "the recording ends"
    (data / "tls.key").write_text("x")
    yield serve + ["--data", str(data)], "tls.key"
    # A limit on the size of files is like a full disk, not a signal that ends the program.
    yield ["bash", "-c", 'ulimit -f 2; exec "$@"', "-", str(binaries / serve[0]), *serve[1:], "--data",
           str(folder / "full")], "full"
    (folder / "long.csv").write_text("t,x,y,z\n" + "".join(f"{i / 1000},0,0,0.2\n" for i in range(100)))
    yield ["bash", "-c", 'ulimit -f 2; exec "$@"', "-", str(binaries / "tandem"), "probe", PUMP, "--path",
           str(folder / "long.csv"), "--tool", "part:impeller", "--ticks",
           str(folder / "long_ticks.csv")], "long_ticks.csv"


def main():
    binaries = binaries_of_command_line()
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        for command, word in cases(pathlib.Path(name), binaries):
            program = command[0] if command[0] == "bash" else binaries / command[0]
            run = subprocess.run([program, *command[1:]], capture_output=True, text=True, timeout=240)
            lines = run.stderr.splitlines()
            if run.returncode != 2 or len(lines) != 1 or word not in lines[0]:
                failures += 1
                print(
                    f"{command}: exit code {run.returncode}, wanted 2 and one line with {word!r}; got "
                    f"{lines[:3]}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
