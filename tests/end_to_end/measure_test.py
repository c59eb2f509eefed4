#!/usr/bin/env python3
"""What a scripted hand measures in a session is in its document, as `tandem check` measures it.

    python3 tests/end_to_end/measure_test.py --bin build/release/bin
"""
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server"))
from server_process import SCENE, Server, run, wait_for  # noqa: E402
from steady import STEADY, steadily  # noqa: E402

AGREES = 1e-6  # m
TOP = [0.055, 0.2, 0.055]  # above a peg
SIDE, OTHER_SIDE = [0.066, 0.02, 0.055], [-0.011, 0.02, 0.055]  # beside two pegs
PEGS = ["peg_0.02", "peg_0.1"]


def step(t, kind, **more):
    return {"t": t, "do": "measure", "measures": kind, **more}


SCRIPT = [step(0.0, "diameter", at=[SIDE], name="peg"), step(0.1, "length", at=[SIDE]),
          step(0.2, "distance", at=[SIDE, OTHER_SIDE]), step(0.3, "across", at=[SIDE, OTHER_SIDE]),
          step(0.4, "angle", at=[SIDE, TOP]), step(0.5, "clearance", at=[SIDE, OTHER_SIDE]),
          step(0.6, "clearance", parts=["bench", "board"]), step(0.7, "diameter", at=[TOP])]


def checked(binaries, *arguments):
    done = subprocess.run([binaries / "tandem", "check", SCENE, "--json", *arguments], capture_output=True,
                          text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def place(at):
    return "--measure=" + ",".join(map(str, at))


def expected(binaries):
    """Kind and value of each measure, from the command."""
    sides = checked(binaries, place(SIDE), place(OTHER_SIDE))
    ends = checked(binaries, place(SIDE), place(TOP))
    side = sides["places"][0]
    bench = checked(binaries, "--distance", "bench", "board")["distance"]
    pegs = checked(binaries, "--distance", *PEGS)["distance"]
    assert abs(sides["parts"]["distance_m"] - pegs["distance_m"]) < 1e-12
    return [("diameter", side["cylinder"]["diameter_m"]), ("length", side["edge"]["length_m"]),
            ("distance", sides["between"]["distance_m"]), ("distance", sides["between"]["across_m"]),
            ("angle", ends["between"]["angle_deg"] * 3.141592653589793 / 180),
            ("clearance", pegs["distance_m"]), ("clearance", bench["distance_m"])]


def a_scripted_hand_measures_as_check_does(binaries, folder):
    with Server(binaries, folder) as server:
        script = folder / "hand.json"
        script.write_text(json.dumps(SCRIPT))
        link = wait_for(lambda: next(iter(server.links("participant")), None), "a link")
        done = subprocess.run([binaries / "tandem", "join", link, "--headless", "--name", "Ada", "--hand",
                               script, "--no-part-contact", "--duration", "2", "--quiet", "--cache",
                               folder / "cache"], capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stderr
        assert done.stderr == "tandem: script: there is no diameter to measure\n", done.stderr
        file = folder / "document.json"
        subprocess.run([binaries / "tandem", "document", server.links("observer")[0], "export", file],
                       check=True, timeout=200, stdout=subprocess.DEVNULL)
        entries = json.loads(file.read_text())["entries"]
        wanted = expected(binaries)
        assert [each["kind"] for each in entries] == ["measure"] * len(wanted), entries
        worst = 0.0
        for entry, (kind, value) in zip(entries, wanted):
            assert entry["measures"] == kind and entry["author"] == "Ada", entry
            assert abs(entry["value"] - value) < AGREES, (entry, value)
            worst = max(worst, abs(entry["value"] - value))
        assert entries[0]["name"] == "peg" and entries[6]["name"] == "bench, board", entries
        print(f"differs by {worst:.3g} m at most")


@steadily
def what_is_held_is_measured_where_it_is(binaries, folder):
    """A peg is lifted and carried; its clearance to the bench is what it was lifted by."""
    script = [step(0.0, "clearance", parts=["bench", "peg_0.02"]),
              {"t": 0.1, "do": "grasp", "part": "peg_0.02", "over_s": 0.3},
              {"t": 0.8, "do": "move_relative", "by": [0, 0.05, 0], "over_s": 0.5},
              step(2.2, "clearance", parts=["bench", "peg_0.02"]), {"t": 2.3, "do": "release"}]
    with Server(binaries, folder) as server:
        path, file, figures = folder / "hand.json", folder / "document.json", folder / "figures.json"
        path.write_text(json.dumps(script))
        done = subprocess.run([binaries / "tandem", "join", server.links("participant")[0], "--headless",
                               "--hand", path, "--no-part-contact", "--duration", "2.8", "--quiet",
                               "--json", figures, "--cache", folder / "cache"],
                              capture_output=True, text=True, timeout=200)
        assert done.returncode == 0 and not done.stderr, done
        STEADY.stalls += json.loads(figures.read_text())["stalls"]
        subprocess.run([binaries / "tandem", "document", server.links("observer")[0], "export", file],
                       check=True, timeout=200, stdout=subprocess.DEVNULL)
        before, held = (entry["value"] for entry in json.loads(file.read_text())["entries"])
        assert abs(before - 0.0002) < 1e-7, before
        assert 0.035 < held < 0.06, held  # the hand is a modelled arm, and the peg hangs from it


if __name__ == "__main__":
    sys.exit(run(a_scripted_hand_measures_as_check_does,
                 what_is_held_is_measured_where_it_is))
