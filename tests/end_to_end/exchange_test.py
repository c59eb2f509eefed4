#!/usr/bin/env python3
"""The session's topics through real processes, to other programs' files and back.

    python3 tests/end_to_end/exchange_test.py --bin build/release/bin

With TANDEM_FULL_SIZE another implementation, which npm fetches, reads an archive and writes it back.
"""
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server"))
from server_process import Server, run, wait_for  # noqa: E402

COMPONENTS = "@thatopen/components"  # another implementation of BCF
VERSION = "3.4.8"
READ_AND_WRITE = """
import * as components from "@thatopen/components";
import fs from "fs";
const [from, to] = process.argv.slice(2);
const bcf = new components.Components().get(components.BCFTopics);
bcf.setup({ version: "3", author: "dan@x.example" });
const { topics, viewpoints } = await bcf.load(new Uint8Array(fs.readFileSync(from)));
const read = [...topics].map(each => ({ title: each.title, type: each.type, status: each.status,
  assigned: each.assignedTo, comments: [...each.comments.values()].map(one => one.comment) }));
const eyes = [...viewpoints].map(each => each.camera.camera_view_point);
const note = [...topics].find(each => each.type === "Note");
note.status = "Closed";
note.modifiedDate = new Date("2031-01-01T00:00:00Z");
note.createComment("Reamed");
const written = await bcf.export(topics);
fs.writeFileSync(to, Buffer.from(await written.arrayBuffer()));
console.log(JSON.stringify({ read, eyes }));
process.exit(0);
"""


class Visits:
    """Runs of `tandem document`, each with a link of its own."""

    def __init__(self, binaries, server, folder):
        self.binaries, self.server, self.folder, self.used = binaries, server, folder, set()

    def run(self, role, action, file, *options):
        link = wait_for(lambda: next((each for each in self.server.links(role) if each not in self.used),
                                     None), "a new link")
        done = subprocess.run([self.binaries / "tandem", "document", link, action, self.folder / file,
                               "--cache", self.folder / "cache", *options],
                              capture_output=True, text=True, timeout=120)
        if done.returncode != 2:
            self.used.add(link)
        return done

    def done(self, role, action, file, *options):
        result = self.run(role, action, file, *options)
        assert result.returncode == 0, (file, result.stderr)
        return result.stdout

    def refused(self, role, action, file, word, *options):
        result = self.run(role, action, file, *options)
        lines = result.stderr.splitlines()
        assert result.returncode == 2 and len(lines) == 1 and word in lines[0], (file, result)

    def entries(self):
        self.done("observer", "export", "now.json")
        return json.loads((self.folder / "now.json").read_text())["entries"]

    def fill(self):
        """An entry of each kind that is a topic."""
        self.done("observer", "export", "empty.json")
        document = json.loads((self.folder / "empty.json").read_text())
        bodies = [
            {"kind": "note", "text": "The peg is tight. Ream the hole", "part": 1, "place_m": [0, 0.01, 0],
             "assignee": "Ben", "status": "open"},
            {"kind": "comment", "note": 1, "text": "=1+1"},
            {"kind": "clash", "a": 0, "b": 1, "status": "reviewed", "depth_m": 0.0012, "text": "as drawn"},
            {"kind": "view", "name": "From above", "distance_m": 0.4, "only_these": False, "parts": [],
             "camera": {"position_m": [0, 0.4, 0], "orientation_wxyz": [0.5 ** 0.5, -0.5 ** 0.5, 0, 0]},
             "sections": [{"point": [0, 0.02, 0], "normal": [0, 1, 0]}]},
            {"kind": "measure", "name": "Pitch", "measures": "distance", "value": 0.1,
             "anchors": [{"part": 0, "point_m": [0, 0, 0]}, {"part": 1, "point_m": [0, 0, 0]}]}]
        document["entries"] = [{"id": i + 1, "author": "x", "made": 0, "changed": 0, **body}
                               for i, body in enumerate(bodies)]
        (self.folder / "fill.json").write_text(json.dumps(document))
        assert self.done("participant", "import", "fill.json").startswith("5 entries made")


def visits(binaries, server, folder):
    visit = Visits(binaries, server, folder.parent)
    visit.fill()
    return visit


def a_table_and_a_page_hold_every_topic(binaries, folder):
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        assert visit.done("observer", "export", "review.csv").startswith("4 topics")
        with open(folder.parent / "review.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert [row["type"] for row in rows] == ["Note", "Clash", "View", "Measure"], rows
        assert rows[0]["title"] == "The peg is tight", rows[0]
        assert rows[0]["thread"].endswith("document: =1+1"), rows[0]
        for options, pictures in (((), 4), (("--no-pictures",), 0)):
            visit.done("observer", "export", "review.html", *options)
            page = (folder.parent / "review.html").read_text(encoding="utf-8")
            assert page.count("<article") == 4 and "From above" in page
            assert page.count("data:image/png;base64,iVBOR") == pictures


def an_archive_is_written_in_both_versions(binaries, folder):
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        for version, name in (("2.1", "old.bcfzip"), ("3.0", "review.bcf")):
            assert visit.done("observer", "export", name, "--bcf", version).startswith("4 topics")
            with zipfile.ZipFile(folder.parent / name) as archive:
                assert archive.testzip() is None
                names = archive.namelist()
                root = ElementTree.fromstring(archive.read("bcf.version"))
                assert root.get("VersionId") == version
                topics = [each for each in names if each.endswith("/markup.bcf")]
                assert len(topics) == 4 == len([each for each in names if each.endswith("/viewpoint.bcfv")])
                assert ("extensions.xml" in names) == ("project.bcfp" in names) == (version == "3.0")
                for each in topics:
                    topic = ElementTree.fromstring(archive.read(each)).find("Topic")
                    assert topic.get("Guid") == each.split("/")[0]
                    picture = archive.read(each.replace("markup.bcf", "snapshot.png"))
                    assert picture.startswith(b"\x89PNG") and len(picture) > 5000, len(picture)
        visit.refused("observer", "export", "review.bcf", "3.0", "--bcf", "4")


def rewritten(archive, into, edit):
    """A copy of an archive with each markup as another program would leave it: `edit(text)`."""
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(into, "w", zipfile.ZIP_DEFLATED) as target:
        for name in source.namelist():
            data = source.read(name)
            target.writestr(name, edit(data.decode()) if name.endswith("/markup.bcf") else data)


def what_another_program_changed_comes_back(binaries, folder):
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        visit.done("observer", "export", "out.bcf")
        unchanged = visit.done("participant", "import", "out.bcf")
        assert unchanged.startswith("0 entries made, 0 changed"), unchanged
        reply = ('<Comment Guid="11111111-2222-4333-8444-555555555555">'
                 '<Date>2031-01-01T00:00:00Z</Date><Author>dan@x.example</Author>'
                 '<Comment>Reamed &amp; measured</Comment></Comment></Comments>')
        rewritten(visit.folder / "out.bcf", visit.folder / "back.bcf",
                  lambda text: text.replace('TopicStatus="Open"', 'TopicStatus="Closed"')
                  .replace("</Comments>", reply))
        told = visit.done("participant", "import", "back.bcf")
        assert told.startswith("1 entries made, 1 changed"), told
        entries = visit.entries()
        assert len(entries) == 6
        assert entries[0]["status"] == "closed" and entries[0]["place_m"] == [0, 0.01, 0], entries[0]
        assert entries[5]["text"] == "[dan@x.example] Reamed & measured" and entries[5]["note"] == 1
        told = visit.done("participant", "import", "back.bcf")
        assert told.startswith("0 entries made, 0 changed"), "the same file again: " + told


def a_damaged_archive_changes_nothing(binaries, folder):
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        visit.done("observer", "export", "out.bcf")
        before = visit.entries()
        whole = (visit.folder / "out.bcf").read_bytes()
        (visit.folder / "half.bcf").write_bytes(whole[:len(whole) // 2])
        visit.refused("participant", "import", "half.bcf", "half.bcf")
        visit.refused("participant", "import", "absent.bcf", "absent.bcf")
        rewritten(visit.folder / "out.bcf", visit.folder / "bad.bcf",
                  lambda text: text.replace('TopicStatus="Open"', 'TopicStatus="Closed"')
                  .replace("<Title>Pitch", "<Title>Pitch</Titel>"))
        visit.refused("participant", "import", "bad.bcf", "markup.bcf")
        assert visit.entries() == before


def other_program(binaries):
    """A folder with the other program, kept beside the build; None without npm or a network."""
    folder = binaries.resolve().parent / "thatopen-components"
    if not (folder / "node_modules" / COMPONENTS).exists():
        if not shutil.which("npm"):
            print("skipped: npm is not there, no other program reads the archive")
            return None
        folder.mkdir(exist_ok=True)
        done = subprocess.run(["npm", "install", "--prefix", folder, f"{COMPONENTS}@{VERSION}"],
                              capture_output=True, timeout=200)
        if done.returncode != 0:
            print(f"skipped: npm cannot fetch {COMPONENTS}, no other program reads the archive")
            return None
    (folder / "read_and_write.mjs").write_text(READ_AND_WRITE)
    return folder


def another_implementation_reads_an_archive_and_its_own_is_read(binaries, folder):
    other = other_program(binaries) if os.environ.get("TANDEM_FULL_SIZE") else None
    if other is None:
        return
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        visit.done("observer", "export", "out.bcf")
        files = [visit.folder / "out.bcf", visit.folder / "back.bcf"]
        done = subprocess.run(["node", "read_and_write.mjs", *files], cwd=other, capture_output=True,
                              text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        told = json.loads(done.stdout.splitlines()[-1])
        topics = {topic["type"]: topic for topic in told["read"]}
        assert len(topics) == 4, topics
        assert topics["Note"] == {"title": "The peg is tight", "type": "Note", "status": "Open",
                                  "assigned": "Ben", "comments": ["=1+1"]}, topics["Note"]
        assert topics["Clash"]["status"] == "Reviewed"
        # It turns its cameras to +y up too: the named view's stands where it was.
        assert any(abs(eye["x"]) < 1e-9 and abs(eye["y"] - 0.4) < 1e-9 and abs(eye["z"]) < 1e-9
                   for eye in told["eyes"]), told["eyes"]
        back = visit.done("participant", "import", "back.bcf")
        assert back.startswith("1 entries made, 1 changed"), back
        entries = visit.entries()
        assert entries[0]["status"] == "closed" and entries[5]["text"] == "[dan@x.example] Reamed", entries


def files_that_cannot_be_are_refused_in_one_line(binaries, folder):
    with Server(binaries, folder) as server:
        visit = visits(binaries, server, folder)
        visit.refused("observer", "export", "review.docx", ".csv")
        visit.refused("participant", "import", "review.csv", ".json")
        assert len(visit.entries()) == 5


if __name__ == "__main__":
    sys.exit(run(a_table_and_a_page_hold_every_topic, an_archive_is_written_in_both_versions,
                 what_another_program_changed_comes_back, a_damaged_archive_changes_nothing,
                 another_implementation_reads_an_archive_and_its_own_is_read,
                 files_that_cannot_be_are_refused_in_one_line))
