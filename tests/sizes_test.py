#!/usr/bin/env python3
"""Holds the sources to sizes that are calm to read, from columns of a line to lines of a class.

  tests/sizes_test.py            names what is over a bound; exit code 1 if anything is
  tests/sizes_test.py --table    prints median, 90th percentile and maximum of each size

The tree is formatted by clang-format, so a function or a class ends at the first brace that stands as deep
as the line that begins it.
"""
import pathlib
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("assets", "haptics", "sync", "server", "client")
MAX_COLUMNS, MAX_FUNCTION, MAX_FILE, MAX_HEADER, MAX_CLASS = 110, 70, 600, 200, 500
MAX_ROOM_README, MAX_MAP_README = 80, 120  # a folder whose rooms lie below it has a map
ASSERTIONS_PER_1000 = {"haptics": 5, "sync": 5, "server": 5}

NO_FUNCTION = re.compile(
    r"\s*(namespace|class|struct|union|enum|extern|using|template|#|//|\}|public|private)|.*=\s*\{$")
CLASS = re.compile(r"^(?:class|struct) (\w+)(?: final)?(?: : [^{;]*)? \{$")
MEMBER = re.compile(r"^[^\s#/].*?\b([A-Z]\w+)::~?\w+\(")
ASSERTION = re.compile(r"\b(?:TICK_)?ASSERT\(")


def sources(root):
    """path -> its lines."""
    return {path: path.read_text(encoding="utf-8").splitlines() for folder in FOLDERS
            for path in sorted((root / folder).rglob("*")) if path.suffix in (".h", ".cpp")}


def functions(lines):
    """(first line, number of lines) of each function at the level of a namespace or of a class in it."""
    number = 0
    while number < len(lines):
        line, indent = lines[number], len(lines[number]) - len(lines[number].lstrip())
        if indent > 2 or "(" not in line or NO_FUNCTION.match(line) or line.endswith(";"):
            number += 1
            continue
        last = number  # of the declaration
        while last < len(lines) and not re.search(r"[{};]$", lines[last]):
            last += 1
        if last == len(lines) or lines[last].endswith(";"):
            number = last + 1
            continue
        if lines[last].endswith("{"):
            closing = " " * indent + "}"
            while last < len(lines) and lines[last].rstrip(";") != closing:
                last += 1
        yield number + 1, last - number + 1
        number = last + 1


def classes(files):
    """(folder, class) -> (files, lines): its declaration, and its functions in the sources of its folder."""
    found = {}
    for path, lines in files.items():
        for number, line in enumerate(lines):
            match = CLASS.match(line)
            if match:
                last = next(i for i in range(number, len(lines)) if lines[i] == "};")
                files_of, count = found.get((path.parent, match.group(1)), (set(), 0))
                found[path.parent, match.group(1)] = (files_of | {path}, count + last - number + 1)
    for path, lines in files.items():
        if path.suffix != ".cpp":
            continue
        for first, count in functions(lines):
            match = MEMBER.match(" ".join(part.strip() for part in lines[first - 1:first + 2]))
            key = (path.parent, match.group(1)) if match else None
            if key in found:
                found[key] = (found[key][0] | {path}, found[key][1] + count)
    return found


def violations(root):
    files, found = sources(root), []

    def name(path):
        return path.relative_to(root).as_posix()

    for path, lines in files.items():
        bound = MAX_HEADER if path.suffix == ".h" else MAX_FILE
        if len(lines) > bound:
            found.append(f"{name(path)}: {len(lines)} lines, at most {bound}")
        found += [f"{name(path)}:{first}: a function of {count} lines, at most {MAX_FUNCTION}"
                  for first, count in functions(lines) if count > MAX_FUNCTION]
    found += [f"{name(folder)}: class {which} has {count} lines, at most {MAX_CLASS}"
              for (folder, which), (_, count) in classes(files).items() if count > MAX_CLASS]
    for path in sorted(root.rglob("*")):
        parts = path.relative_to(root).parts
        if parts[0] in FOLDERS + ("tests",) and path.suffix in (".h", ".cpp", ".py"):
            found += [f"{name(path)}:{number}: {len(line)} columns, at most {MAX_COLUMNS}"
                      for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
                      if len(line) > MAX_COLUMNS]
        if parts[0] in FOLDERS and path.name == "README.md":
            bound = MAX_MAP_README if len(parts) == 2 else MAX_ROOM_README
            count = len(path.read_text(encoding="utf-8").splitlines())
            if count > bound:
                found.append(f"{name(path)}: {count} lines, at most {bound}")
    for folder, least in ASSERTIONS_PER_1000.items():
        share = density(files, root / folder)
        if share < least:
            found.append(f"{folder}: {share:.1f} assertions a thousand lines, at least {least}")
    return found


def density(files, folder):
    inside = [lines for path, lines in files.items() if folder in path.parents]
    total = sum(len(lines) for lines in inside)
    checks = sum(len(ASSERTION.findall(line)) for lines in inside for line in lines)
    return 1000 * checks / total if total else float("inf")


def table(root):
    files = sources(root)

    def row(what, sizes):
        sizes = sorted(sizes)
        at = [sizes[min(len(sizes) - 1, int(share * len(sizes)))] for share in (0.5, 0.9, 0.99)]
        print(f"{what:28} {len(sizes):6} {at[0]:7} {at[1]:6} {at[2]:6} {sizes[-1]:6}")

    print(f"{'':28} {'number':>6} {'median':>7} {'p90':>6} {'p99':>6} {'max':>6}")
    row("files, lines", [len(lines) for lines in files.values()])
    row("headers, lines", [len(lines) for path, lines in files.items() if path.suffix == ".h"])
    row("functions, lines", [count for lines in files.values() for _, count in functions(lines)])
    row("classes, lines in all files", [count for _, count in classes(files).values()])
    every = [line.strip() for lines in files.values() for line in lines if line.strip()]
    comments = sum(line.startswith("//") for line in every)
    print(f"comments, of lines with text: {100 * comments / len(every):.0f} %")
    for folder in FOLDERS:
        print(f"assertions a thousand lines, {folder}: {density(files, root / folder):.1f}")


def self_test():
    """A check that cannot fail is none: each kind of violation in a made-up tree must be found."""
    body = "  step();\n" * 70
    members = "".join(f"void Wide::part{i}() {{\n" + "  step();\n" * 60 + "}\n\n" for i in range(5))
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "haptics/room").mkdir(parents=True)
        (root / "haptics/room/long.h").write_text("//\n" * 201, encoding="utf-8")
        (root / "haptics/room/wide.h").write_text("class Wide {\n};\n", encoding="utf-8")
        (root / "haptics/room/wide.cpp").write_text(members, encoding="utf-8")
        (root / "haptics/room/wider.cpp").write_text(members, encoding="utf-8")
        (root / "haptics/room/steps.cpp").write_text(f"void steps(int a,\n           int b) {{\n{body}}}\n",
                                                     encoding="utf-8")
        (root / "haptics/room/README.md").write_text("\n" * 81, encoding="utf-8")
        (root / "haptics/README.md").write_text("\n" * 121, encoding="utf-8")
        (root / "haptics/room/line.cpp").write_text("/" * 111 + "\n", encoding="utf-8")
        return sorted(violations(root)) == sorted([
            "haptics/room/long.h: 201 lines, at most 200",
            "haptics/room: class Wide has 622 lines, at most 500",
            "haptics/room/steps.cpp:1: a function of 73 lines, at most 70",
            "haptics/room/README.md: 81 lines, at most 80",
            "haptics/README.md: 121 lines, at most 120",
            "haptics/room/line.cpp:1: 111 columns, at most 110",
            "haptics: 0.0 assertions a thousand lines, at least 5",
        ])


if __name__ == "__main__":
    if sys.argv[1:] == ["--table"]:
        table(ROOT)
        sys.exit(0)
    if not self_test():
        sys.exit("the check does not find what it must")
    problems = violations(ROOT)
    print("\n".join(problems) or "every size is within its bound")
    sys.exit(1 if problems else 0)
