#!/usr/bin/env python3
"""Holds each room's sources to names of their own, so that they can be compiled as one (TANDEM_UNITY).

What stands in an unnamed namespace is private to its source only while sources are compiled one by one.
Compiled together, two functions of one name are overloads of each other, and a call may silently take the
other one. Exit code 1 names every function, type and constant that two sources of a room both have; aliases
(`using`) may repeat, for the compiler refuses those that differ. Rooms of TANDEM_ONE_BY_ONE in CMakeLists.txt
are left out.
"""
import collections
import pathlib
import re
import sys
import tempfile

from include_order_test import read_table

ROOT = pathlib.Path(__file__).resolve().parent.parent
ONE_BY_ONE = re.compile(r"set\(TANDEM_ONE_BY_ONE ([^)]*)\)")
TYPE = re.compile(r"(?:struct|class|enum class|enum) (\w+)")
VARIABLE = re.compile(r"(?:constexpr|const|thread_local|static|std::atomic)\b[^(]*$")
ASSIGNED = re.compile(r"(\w+)(?:\[\w*\])? =(?: |$)")
BRACED = re.compile(r"(\w+)(?:\[\w*\])?\{")
FUNCTION = re.compile(r"[A-Za-z_][^(=]*?[\s&*>](\w+)\(")


def private_names(source):
    """Names at the outermost level of a source's unnamed namespace, which clang-format puts in column 0."""
    inside = False
    for line in source.splitlines():
        if line.startswith("namespace {"):
            inside = True
        elif line == "}  // namespace":
            inside = False
        elif inside and (found := TYPE.match(line)):
            yield found[1]
        elif inside and VARIABLE.match(line.split("=")[0].split("{")[0]):
            yield from (ASSIGNED if "=" in line else BRACED).findall(line)
        elif inside and not line.startswith(("//", "using ", "template")):
            if found := FUNCTION.match(line):
                yield found[1]


def violations(root):
    one_by_one = ONE_BY_ONE.search((root / "CMakeLists.txt").read_text(encoding="utf-8"))[1].split()
    found = []
    for room in read_table(root):
        sources = collections.defaultdict(set)
        for path in sorted((root / room).glob("*.cpp")):
            for name in private_names(path.read_text(encoding="utf-8")):
                sources[name].add(path.name)
        if room not in one_by_one:
            found += [f"{room}: {' and '.join(sorted(own))} both have {name}" for name, own in sources.items()
                      if len(own) > 1]
    return found


def self_test():
    """A check that cannot fail is none: each kind of name in a made-up tree must be found, and no other."""
    first = ("namespace {\nconstexpr double kA = 1.0, kB = 2.0;\nstruct C {\n  int kD = 1;\n};\n"
             "using D = int;\n// A call of calls(1) is not a name.\nint f(int x) {\n  return g(x);\n}\n"
             "}  // namespace\nint shown() {\n}\n")
    second = ("namespace {\nconst int kB{1};\nclass C {};\nusing D = int;\ndouble f() { return kA; }\n"
              "}  // namespace\nint shown() {\n}\n")
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "CMakeLists.txt").write_text('set(TANDEM_ROOMS\n  "assets:"\n  "sync: assets"\n)\n'
                                             "set(TANDEM_ONE_BY_ONE sync)\n", encoding="utf-8")
        for room in ("assets", "sync"):
            (root / room).mkdir()
            (root / room / "first.cpp").write_text(first, encoding="utf-8")
            (root / room / "second.cpp").write_text(second, encoding="utf-8")
        return violations(root) == [f"assets: first.cpp and second.cpp both have {name}"
                                    for name in ("kB", "C", "f")]


if __name__ == "__main__":
    if not self_test():
        sys.exit("the check does not find what it must")
    problems = violations(ROOT)
    print("\n".join(problems) or "every room's private names are its sources' own")
    sys.exit(1 if problems else 0)
