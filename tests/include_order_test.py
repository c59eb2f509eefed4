#!/usr/bin/env python3
"""Holds the sources to the order of the folders: who may include whom, and that no header is an umbrella's victim.

Exit code 1 names every include against the order.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ALLOWED = {
    "assets": {"assets"},
    "haptics": {"haptics", "assets"},
    "sync": {"sync", "assets"},
    "server": {"server", "sync", "assets"},
    "client": {"client", "haptics", "sync", "assets"},
}
# The simulate command alone runs the server's session inside the client.
EXCEPTIONS = {("client/simulation/", "server")}
INCLUDE = re.compile(r'^\s*#\s*include\s+"([a-z_]+)/')


def violations(root):
    found = []
    for folder, allowed in ALLOWED.items():
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            name = path.relative_to(root).as_posix()
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                match = INCLUDE.match(line)
                if not match or match.group(1) in allowed:
                    continue
                target = match.group(1)
                if any(name.startswith(prefix) and target == other for prefix, other in EXCEPTIONS):
                    continue
                found.append(f"{name}:{number}: {folder} must not include {target}: {line.strip()}")
    return found


def self_test(tmp):
    """A check that cannot fail is none: a forbidden include in a made-up tree must be found."""
    (tmp / "sync").mkdir(parents=True)
    (tmp / "sync" / "bad.cpp").write_text('#include "haptics/tick.h"\n', encoding="utf-8")
    return len(violations(tmp)) == 1


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as directory:
        if not self_test(pathlib.Path(directory)):
            sys.exit("the check did not find a forbidden include")
    problems = violations(ROOT)
    print("\n".join(problems) or "every include follows the order of the folders")
    sys.exit(1 if problems else 0)
