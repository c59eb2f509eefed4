#!/usr/bin/env python3
"""The session's document through real processes: export, import, kill -9 of the server in an import.

    python3 tests/server/document_test.py --bin build/release/bin
"""
import json
import re
import subprocess
import sys
import time

from server_process import Server, run, wait_for


def document(binaries, link, action, file):
    done = subprocess.run([binaries / "tandem", "document", link, action, file],
                          capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout, done.stderr


def fresh(server, role, used):
    """A link of the role that was not used yet."""
    link = wait_for(lambda: next((each for each in server.links(role) if each not in used), None),
                    "a new link")
    used.add(link)
    return link


def exported(binaries, server, used, file):
    code, _, error = document(binaries, fresh(server, "observer", used), "export", file)
    assert code == 0, error
    return json.loads(file.read_text())


def notes(scene, count):
    return {"tandem_document": 1, "scene": scene, "entries": [
        {"id": i + 1, "kind": "note", "author": "x", "made": 0, "changed": 0, "text": f"note {i}",
         "part": None, "place_m": [0, 0, 0.001 * i], "assignee": "", "status": "open"} for i in range(count)]}


def what_was_told_survives_kill_9_and_an_import_may_be_repeated(binaries, folder):
    used = set()
    file, back = folder.parent / "notes.json", folder.parent / "back.json"
    with Server(binaries, folder) as server:
        scene = exported(binaries, server, used, back)["scene"]
        file.write_text(json.dumps(notes(scene, 1000)))
        importing = subprocess.Popen(
            [binaries / "tandem", "document", fresh(server, "participant", used), "import", file],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(3.0)  # of some seven; a sanitizer starts slowly
        server.process.kill()
        out, error = importing.communicate(timeout=60)
    assert importing.returncode == 1, (importing.returncode, out, error)
    told = int(re.match(r"(\d+) entries made", out).group(1))
    assert 0 < told < 1000, out
    with Server(binaries, folder) as server:
        kept = {entry["text"] for entry in exported(binaries, server, used, back)["entries"]}
        assert len(kept) >= told, (len(kept), told)
        assert {f"note {i}" for i in range(told)} <= kept, "the first that were answered are there"
        code, out, error = document(binaries, fresh(server, "participant", used), "import", file)
        assert code == 0, error
        assert f"{len(kept)} there already" in out, out
        entries = exported(binaries, server, used, back)["entries"]
        assert len(entries) == 1000 and len({entry["text"] for entry in entries}) == 1000


def a_file_that_does_not_fit_is_refused_before_anything_changes(binaries, folder):
    used = set()
    file, back = folder.parent / "notes.json", folder.parent / "back.json"
    with Server(binaries, folder) as server:
        scene = exported(binaries, server, used, back)["scene"]
        file.write_text(json.dumps(notes("0" * 64, 3)))
        code, _, error = document(binaries, fresh(server, "participant", used), "import", file)
        assert code == 2 and "another scene" in error and error.count("\n") == 1, (code, error)
        link = fresh(server, "participant", used)
        bad = notes(scene, 3)
        bad["entries"][2]["status"] = "lost"
        file.write_text(json.dumps(bad))
        code, _, error = document(binaries, link, "import", file)
        assert code == 2 and "entries[2]" in error and error.count("\n") == 1, (code, error)
        file.write_text(json.dumps(notes(scene, 3)))
        observer = fresh(server, "observer", used)
        code, _, error = document(binaries, observer, "import", file)
        assert code == 2 and "observer" in error, (code, error)
        used.discard(observer)  # it was not spent
        code, out, error = document(binaries, link, "import", file)
        assert code == 0, "the link was not spent on the bad file: " + error
        assert len(exported(binaries, server, used, back)["entries"]) == 3


if __name__ == "__main__":
    sys.exit(run(what_was_told_survives_kill_9_and_an_import_may_be_repeated,
                 a_file_that_does_not_fit_is_refused_before_anything_changes))
