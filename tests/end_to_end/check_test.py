#!/usr/bin/env python3
"""tandem check names what surfaces, fields and controls do, and refuses a bad value in one line.

    python3 tests/end_to_end/check_test.py --bin build/release/bin
"""
import json
import pathlib
import sys
import tempfile

from check_command import SCENES, binaries_of_command_line, expect, report, run


# Part of surfaces.glb to what makes it special.
PLATES = {
    "damping": ("damping", "damping_ns_per_m", 8.0), "friction": ("friction", "static", 0.8),
    "friction map": ("texture", "friction_scale", 4.0), "image relief": ("texture", "amplitude_m", 0.0003),
    "waves": ("texture", "wavelength_m", 0.004), "grid": ("texture", "is", "grid"),
    "bumps": ("texture", "is", "bumps"), "noise": ("texture", "is", "noise"),
    "viscosity": ("viscosity", "viscosity_ns_per_m", 6.0), "vibration": ("vibration", "frequency_hz", 80.0),
    "stick-slip": ("stick-slip", "force_n", 0.6), "magnet": ("magnetic", "distance_m", 0.008),
    "pop-through": ("pop-through", "force_n", 1.5), "viscoelastic": ("law", "relaxation_s", 0.25),
    "plastic": ("law", "hardening_n_per_m", 120.0), "smooth dome": ("shading", "crease_angle_rad", 0.5),
}
BAD = {
    "viscosity": -1, "vibration": {"frequency": "fast", "amplitude": 1}, "law": "jelly",
    "texture": {"function": "wood", "amplitude": 1e-4, "wavelength": 1e-3}, "magnetic": [1, 2],
    "stiffness": 1e308, "stickSlip": {"force": 1e308, "stiffness": 1},
}


def one_box(haptic):
    """A glTF file of one triangle whose node says how it feels."""
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "plate", "mesh": 0, "extras": {"haptic": haptic}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,"
                     "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})


def check_samples(binaries):
    result = run(binaries, SCENES / "surfaces.glb", "--json", "--device", "damped")
    plates = {entry["part"]: entry for entry in json.loads(result.stdout)["surfaces"]}
    for part, (effect, key, value) in PLATES.items():
        is_ = plates.get(part, {}).get("effects", {}).get(effect, {}).get(key)
        expect(is_ == value, f"{part}: {effect}.{key} is {is_}, not {value}")
        expect(not plates.get(part, {}).get("remarks"), f"{part} has remarks")
    text = run(binaries, SCENES / "surfaces.glb").stdout
    expect("surface magnet, steel: stiffness 1000 N/m; magnetic force 0.8 N, distance 0.008 m" in text,
           "the table does not name the magnet")
    panel = json.loads(run(binaries, SCENES / "control_panel.glb", "--json").stdout)
    controls = {entry["part"]: entry for entry in panel["controls"]}
    expect(controls["start"]["kind"] == "button", "the button is not named")
    expect(controls["start"]["effects"]["click"]["drop_n"] == 0.8, "the click is not named")
    expect(controls["gauge layer"]["effects"]["roles"]["is"] == "instructor", "the layer's role is not named")
    expect("control" in run(binaries, SCENES / "control_panel.glb").stdout, "the table names no control")
    fields = json.loads(run(binaries, SCENES / "solar_system.glb", "--json").stdout)["fields"]
    expect(len(fields) == 6 and all(f["kind"] == "gravity" for f in fields), "the fields are not named")


def check_parts(binaries):
    parts = json.loads(run(binaries, SCENES / "control_panel.glb", "--json").stdout)["parts"]
    diagonal_bound = 1e-8  # m: a share of a panel of decimetres
    for part in parts:
        if part["name"] == "gauge":
            expect(part["ticks_touching"] == 0, "a hidden part is touched")
            continue
        expect(part["ticks_touching"] > 100, f"{part['name']} is hardly touched")
        expect(0 < part["error_m"] < diagonal_bound, f"{part['name']}: error {part['error_m']} m")


def check_remarks(binaries):
    """Once a kind in the table, all of them in JSON."""
    scene = SCENES / "surfaces.glb"
    lines = [line for line in run(binaries, scene).stdout.splitlines() if line.startswith("remark")]
    stiff = [line for line in lines if ": stiffness is felt as" in line]
    expect(len(stiff) == 1 and "and 17 more" in stiff[0], f"remarks on stiffness: {stiff}")
    expect(any("magnetic pull changes by 400 N/m" in line for line in lines),
           "the steep magnet has no remark")
    surfaces = json.loads(run(binaries, scene, "--json").stdout)["surfaces"]
    count = sum("stiffness is felt as" in text and "stick-slip" not in text
                for surface in surfaces for text in surface["remarks"])
    expect(count == 18, f"JSON has {count} remarks on stiffness")
    fields = json.loads(run(binaries, SCENES / "guided_path.glb", "--json").stdout)["fields"]
    expect(fields[0]["effects"]["spring"]["stiffness_n_per_m"] == 180.0, "the guide's stiffness is not named")


def check_grasp(binaries):
    """K <= b / (T/2 + t_d), for turning as well where the device has the motors for it."""
    scene = SCENES / "peg_board.glb"
    for device, delay, force, torque in (("desktop", 0, 200, None), ("sixdof", 0, 600, 2),
                                         ("sixdof", 5, 0.3 / 5.5e-3, 1 / 5.5)):
        grasp = json.loads(run(binaries, scene, "--json", "--device", device, "--delay-ms",
                               str(delay)).stdout)["grasp"]
        expect(abs(grasp["stiffest_n_per_m"] / force - 1) < 1e-9, f"{device}: {grasp}")
        turning = grasp["stiffest_n_m_per_rad"]
        expect(turning is torque if torque is None else abs(turning / torque - 1) < 1e-9,
               f"{device}: {grasp}")
        expect(grasp["used_n_per_m"] <= grasp["stiffest_n_per_m"] and not grasp["defaults_kept"],
               f"{device}: {grasp}")
    text = run(binaries, scene, "--device", "sixdof").stdout
    expect("stiffest stable grasp: 600 N/m and 2 N*m/rad" in text, text)
    expect("drives no torque" in run(binaries, scene).stdout,
           "a device without torque motors has a limit of turning")
    kept = json.loads(run(binaries, scene, "--json", "--device", "damped").stdout)["grasp"]
    expect(kept["defaults_kept"] and kept["used_n_per_m"] == 800, f"{kept}")


def check_bad_values(binaries, folder):
    scene = folder / "bad.gltf"
    for key, value in BAD.items():
        scene.write_text(one_box({key: value}))
        result = run(binaries, scene)
        lines = result.stderr.strip().splitlines()
        expect(result.returncode == 2 and len(lines) == 1 and "bad.gltf" in lines[0] and key in lines[0],
               f"{key}: {result.returncode} {result.stderr!r}")
    scene.write_text(one_box({"vibration": {"frequency": 700, "amplitude": 0.2}}))
    result = run(binaries, scene)
    remarks = [line for line in result.stdout.splitlines() if line.startswith("remark")]
    expect(result.returncode == 0 and len(remarks) == 1 and "700 Hz" in remarks[0], f"{remarks}")


def main():
    binaries = binaries_of_command_line()
    check_samples(binaries)
    check_parts(binaries)
    check_remarks(binaries)
    check_grasp(binaries)
    with tempfile.TemporaryDirectory() as folder:
        check_bad_values(binaries, pathlib.Path(folder))
    return report()


if __name__ == "__main__":
    sys.exit(main())
