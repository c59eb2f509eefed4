#!/usr/bin/env python3
"""Clashes of a session keep their status, and who gave it, through searches by a hand and by the command.

    python3 tests/end_to_end/verdicts_test.py --bin build/release/bin
"""
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server"))
from server_process import Server, run, wait_for  # noqa: E402
from steady import STEADY, steadily  # noqa: E402

PEG, BOARD = "peg_0.5", "board"
NOTHING = "0 clashes are new, 0 are gone, 0 are back"


def carry(z, *then):
    """A hand takes the peg, carries it up and along z without collisions, writes, and lets it go."""
    return [{"t": 0.0, "do": "grasp", "part": PEG, "over_s": 0.3},
            {"t": 1.0, "do": "move_relative", "by": [0, 0.01, z], "over_s": 0.5},
            {"t": 2.0, "do": "find_clashes"}, *then, {"t": 2.3, "do": "release"}]


class Runs:
    def __init__(self, binaries, server, folder):
        self.binaries, self.server, self.folder, self.used = binaries, server, folder, set()

    def link(self, role):
        link = wait_for(lambda: next((each for each in self.server.links(role) if each not in self.used),
                                     None), "a new link")
        self.used.add(link)
        return link

    def done(self, *arguments):
        done = subprocess.run([self.binaries / "tandem", *arguments, "--cache", self.folder / "cache"],
                              capture_output=True, text=True, timeout=200)
        assert done.returncode == 0 and "script:" not in done.stderr, done
        return done.stdout

    def hand(self, name, script):
        path, figures = self.folder / "hand.json", self.folder / "figures.json"
        path.write_text(json.dumps(script))
        self.done("join", self.link("participant"), "--headless", "--name", name, "--hand", path,
                  "--json", figures, "--no-part-contact", "--duration", "3", "--quiet")
        STEADY.stalls += json.loads(figures.read_text())["stalls"]

    def verdicts(self):
        path = self.folder / "document.json"
        self.done("document", self.link("observer"), "export", path)
        return [each for each in json.loads(path.read_text())["entries"] if each["kind"] == "clash"]


@steadily
def a_clash_keeps_its_status_until_it_is_gone(binaries, folder):
    with Server(binaries, folder) as server:
        runs = Runs(binaries, server, folder)
        judge = {"t": 2.1, "do": "judge", "parts": [PEG, BOARD], "status": "reviewed", "text": "ream it"}
        runs.hand("Ada", carry(-0.05, judge))
        verdicts = runs.verdicts()
        assert len(verdicts) == 1, verdicts
        assert verdicts[0]["status"] == "reviewed" and verdicts[0]["text"] == "[Ada] ream it", verdicts
        assert 0.001 < verdicts[0]["depth_m"] < 0.01, verdicts
        found = [runs.done("document", runs.link("participant"), "clashes", "--name", "Cy") for _ in range(2)]
        assert found[0].startswith(NOTHING), found  # the peg has come to rest at another depth
        assert found[1].startswith(NOTHING + ", 0 are of another depth"), found
        page = folder / "review.html"
        runs.done("document", runs.link("observer"), "export", page, "--no-pictures")
        assert "[Ada] ream it" in page.read_text()
        runs.hand("Ben", carry(0.05))
        verdicts = runs.verdicts()
        assert [each["status"] for each in verdicts] == ["resolved"], verdicts
        assert verdicts[0]["text"] == "[Ben] ream it", verdicts


def an_observer_changes_nothing(binaries, folder):
    with Server(binaries, folder) as server:
        for link, words in ((server.links("observer")[0], ["clashes"]),
                            (server.links("participant")[0], ["clashes", "file.json"]),
                            (server.links("participant")[0], ["export"])):
            done = subprocess.run([binaries / "tandem", "document", link, *words], capture_output=True,
                                  text=True, timeout=100)
            assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done


if __name__ == "__main__":
    sys.exit(run(a_clash_keeps_its_status_until_it_is_gone, an_observer_changes_nothing))
