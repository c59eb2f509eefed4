#!/usr/bin/env python3
"""What one site shows and says, at another through real processes; who stops following has their own back.

    python3 tests/end_to_end/presenting_test.py --bin build/release/bin
"""
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server"))
from server_process import Server, run, wait_for  # noqa: E402

PART = "peg_0.5"


class Visitor:
    """A headless site with a script; what it wrote down once it has left."""

    def __init__(self, binaries, folder, link, name, script, *options):
        self.json, self.out = folder / f"{name}.json", folder / f"{name}.out"
        path = folder / f"{name}.script"
        path.write_text(json.dumps(script))
        self.process = subprocess.Popen(
            [binaries / "tandem", "join", link, "--headless", "--name", name, "--hand", path, "--json",
             self.json, "--no-part-contact", "--duration", "30", *options],
            stdout=open(self.out, "w"), stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            env=dict(os.environ, XDG_CACHE_HOME=str(folder / "cache")))

    def said(self, words):
        return words in self.out.read_text()

    def leave(self):
        self.process.terminate()
        assert self.process.wait(20) == 0, self.out.read_text()
        return self.report()["presenting"]

    def report(self):
        return json.loads(self.json.read_text())


def step(t, verb, **members):
    return {"t": t, "do": verb, **members}


def test_presenting(binaries, folder):
    with Server(binaries, folder) as server:
        shows = [step(0.5, "section", planes=[[0, 0, 1, 0.04]]), step(0.5, "hide", parts=[PART]),
                 step(0.5, "select", part=PART), step(0.5, "point", part=PART),
                 step(0.5, "inspect", parts=[PART, "board"], at=[[0, 0, 0]]),
                 step(0.5, "share", what="view"), step(2, "say", text=f"look at the [{PART}]")]
        watches = [step(0, "section", planes=[[1, 0, 0, 0.5]])]
        eve_stops = watches + [step(1, "follow", what="nothing"), step(3, "say", text="I look elsewhere")]
        ben = Visitor(binaries, folder, server.links("participant")[0], "Ben", watches)
        wait_for(lambda: ben.said("connected"), "Ben is there")
        eve = Visitor(binaries, folder, wait_for(lambda: server.links("participant")[1:], "a link")[0], "Eve",
                      eve_stops)
        wait_for(lambda: ben.said("Eve joined"), "Eve is there")
        ada = Visitor(binaries, folder, server.links("instructor")[0], "Ada", shows)
        wait_for(lambda: ben.said("Ada presents"), "Ben hears that Ada presents")
        wait_for(lambda: ben.said(f"Ada says: look at the {PART}"), "Ben hears Ada")
        wait_for(lambda: ben.said("Eve says: I look elsewhere"), "Ben hears Eve")
        got, own = ben.leave(), eve.leave()
        shown = ada.leave()
        late = Visitor(binaries, folder, wait_for(lambda: server.links("observer"), "a link")[0], "Late", [])
        wait_for(lambda: late.said(f"Ada said: look at the {PART}"), "who comes late hears what was said")
        earlier = late.leave()["said"]
        assert [(line["by"], line["earlier"]) for line in earlier] == [("Ada", True), ("Eve", True)], earlier
        assert all(not line["earlier"] for line in got["said"]), got
        assert (got["shared_by"], got["shared"], got["follows"]) == ("Ada", "view", "view"), got
        assert [plane["point"] for plane in got["sections"]] == [[0, 0, 0.04]], got
        assert (got["hidden"], got["selected"]) == ([PART], PART), got
        assert {got["clash"]["a"], got["clash"]["b"]} == {PART, "board"}, got
        assert got["measuring"] and len(got["marks"]) == 1, got
        assert [(each["by"], each["part"]) for each in got["points"]] == [("Ada", PART)], got
        assert [line["by"] for line in got["said"]] == ["Ada", "Eve"], got
        assert (own["shared_by"], own["follows"]) == ("Ada", "nothing"), own
        assert [plane["point"] for plane in own["sections"]] == [[0.5, 0, 0]], own
        assert shown["shares"] == "view" and shown["shared_by"] == "", shown


def test_voice(binaries, folder):
    url = "mumble://voice.example.org:64738/review"
    with Server(binaries, folder, "--voice-url", url) as server:
        ben = Visitor(binaries, folder, server.links("observer")[0], "Ben", [])
        wait_for(lambda: ben.said(f"People talk at {url}"), "Ben is told where people talk")
        ben.leave()
        assert ben.report()["voice_url"] == url, ben.report()


if __name__ == "__main__":
    sys.exit(run(test_presenting, test_voice))
