#!/usr/bin/env python3
"""Holds the sources to the table of rooms in CMakeLists.txt: who may include whom, without a circle.

A room may include itself, the rooms of its row and whatever those stand on. A row may name only rooms above
it in the table, so that there is no circle, and only rooms that it includes. Exit code 1 names every include
and every row against that.
"""
import pathlib
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("assets", "haptics", "sync", "server", "client")
TABLE = re.compile(r"set\(TANDEM_ROOMS\n(.*?)\n\)", re.DOTALL)
ROW = re.compile(r'"([a-z_/]+):([a-z_/ ]*)"')
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"')


def read_table(root):
    """room -> the rooms of its row, in the order of the table."""
    table = TABLE.search((root / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
    return {room: below.split() for room, below in ROW.findall(table)}


def violations(root):
    rooms, allowed, found = read_table(root), {}, []
    for room, below in rooms.items():
        allowed[room] = {room}
        for other in below:
            if other not in allowed or other == room:
                found.append(f"CMakeLists.txt: {room} names {other}, which does not stand above it in "
                             "the table")
            else:
                allowed[room] |= allowed[other]
    included = {room: set() for room in rooms}
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            name, room = path.relative_to(root).as_posix(), path.relative_to(root).parent.as_posix()
            if room not in rooms:
                found.append(f"{name}: {room} is no room of the table in CMakeLists.txt")
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                match = INCLUDE.match(line)
                if not match:
                    continue
                target = match.group(1).rpartition("/")[0]
                included[room].add(target)
                if target not in allowed[room]:
                    found.append(f"{name}:{number}: {room} must not include {target}: {line.strip()}")
    for room, below in rooms.items():
        found += [f"CMakeLists.txt: {room} does not include {other}" for other in below
                  if other not in included[room]]
    return found


def self_test():
    """A check that cannot fail is none: each kind of violation in a made-up tree must be found."""
    table = ('set(TANDEM_ROOMS\n  "assets:"\n  "haptics: assets"\n'
             '  "sync: assets client"\n  "client: sync"\n)\n')
    expected = [
        "CMakeLists.txt: sync names client, which does not stand above it in the table",
        'sync/bad.cpp:1: sync must not include haptics: #include "haptics/tick.h"',
        "sync/attic/lost.h: sync/attic is no room of the table in CMakeLists.txt",
        "CMakeLists.txt: haptics does not include assets",
        "CMakeLists.txt: sync does not include client",
        "CMakeLists.txt: client does not include sync",
    ]
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "CMakeLists.txt").write_text(table, encoding="utf-8")
        (root / "sync/attic").mkdir(parents=True)
        (root / "sync/bad.cpp").write_text('#include "haptics/tick.h"\n#include "assets/pose.h"\n',
                                           encoding="utf-8")
        (root / "sync/attic/lost.h").write_text("", encoding="utf-8")
        return sorted(violations(root)) == sorted(expected)


if __name__ == "__main__":
    if not self_test():
        sys.exit("the check does not find what it must")
    problems = violations(ROOT)
    print("\n".join(problems) or "every include follows the table of rooms")
    sys.exit(1 if problems else 0)
