#!/usr/bin/env python3
"""Holds the sources of a room, and of a folder of tests, to names of their own, so that they can be compiled
as one (TANDEM_UNITY).

What stands in an unnamed namespace is private to its source only while sources are compiled one by one.
Compiled together, two functions of one name are overloads of each other, and a call may silently take the
other one; and a constant of one hides a public one of that name from those behind it. Exit code 1 names every
function, type and constant that two sources of a room both have, and every constant that is private to one
and used by another. Aliases (`using`) may repeat, for the compiler refuses those that differ. Rooms of
TANDEM_ONE_BY_ONE in CMakeLists.txt are left out, and tests/bench and tests/support, whose sources make
programs of their own.
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
CONSTANT = re.compile(r"k[A-Z]\w*")
USED = re.compile(r"(?<![\w.:>])k[A-Z]\w*")
DECLARATION = re.compile(r"\bconst(?:expr)? [^;]*")
DECLARED = re.compile(r"\b(k[A-Z]\w*)(?:\[\])? ?[={(]")
UNREAD = re.compile(r'//[^\n]*|"(?:[^"\\\n]|\\.)*"')
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
    tests = {str(path.parent.relative_to(root)) for path in root.glob("tests/**/*_test.cpp")}
    found = []
    for room in sorted(read_table(root)) + sorted(tests - {"tests/bench", "tests/support"}):
        texts = {path.name: path.read_text(encoding="utf-8") for path in sorted((root / room).glob("*.cpp"))}
        if room not in one_by_one:
            found += [f"{room}: {problem}" for problem in [*shared_names(texts), *hidden_constants(texts)]]
    return found


def shared_names(texts):
    sources = collections.defaultdict(set)
    for source, text in texts.items():
        for name in private_names(text):
            sources[name].add(source)
    for name, own in sources.items():
        if len(own) > 1:
            yield f"{' and '.join(sorted(own))} both have {name}"


def hidden_constants(texts):
    """Constants that a source has for itself and another takes from elsewhere: a header, or its class."""
    used = {}
    for source, text in texts.items():
        read = UNREAD.sub("", text)
        declared = set(DECLARED.findall(" ; ".join(DECLARATION.findall(read))))
        used[source] = set(USED.findall(read)) - declared - set(private_names(text))
    for source, text in texts.items():
        for name in sorted(set(filter(CONSTANT.fullmatch, private_names(text)))):
            for other in used:
                if other != source and name in used[other]:
                    yield f"{other} means another {name} than that of {source}"


def self_test():
    """A check that cannot fail is none: each kind of name in a made-up tree must be found, and no other."""
    first = ("namespace {\nconstexpr double kA = 1.0, kB = 2.0;\nstruct C {\n  int kD = 1;\n};\n"
             "using D = int;\n// A call of calls(1) is not a name.\nint f(int x) {\n  return g(x);\n}\n"
             "}  // namespace\nint shown() {\n  return kA + kPublic;\n}\n")
    second = ("namespace {\nconst int kB{1};\nclass C {};\nusing D = int;\ndouble f() { return kA; }\n"
              "constexpr int kPublic = 2;\n}  // namespace\nint shown() {\n}\n")
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "CMakeLists.txt").write_text('set(TANDEM_ROOMS\n  "assets:"\n  "sync: assets"\n)\n'
                                             "set(TANDEM_ONE_BY_ONE sync)\n", encoding="utf-8")
        for room in ("assets", "sync", "tests/sync"):
            (root / room).mkdir(parents=True)
            (root / room / "first.cpp").write_text(first, encoding="utf-8")
            (root / room / "second.cpp").write_text(second, encoding="utf-8")
        (root / "tests/sync/second.cpp").rename(root / "tests/sync/second_test.cpp")
        wanted = []
        for room, other in (("assets", "second.cpp"), ("tests/sync", "second_test.cpp")):
            wanted += [f"{room}: first.cpp and {other} both have {name}" for name in ("kB", "C", "f")]
            wanted += [f"{room}: {other} means another kA than that of first.cpp",
                       f"{room}: first.cpp means another kPublic than that of {other}"]
        return violations(root) == wanted


if __name__ == "__main__":
    if not self_test():
        sys.exit("the check does not find what it must")
    problems = violations(ROOT)
    print("\n".join(problems) or "every room's private names are its sources' own")
    sys.exit(1 if problems else 0)
