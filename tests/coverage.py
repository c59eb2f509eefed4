#!/usr/bin/env python3
"""Says which lines of server and sync are reached by their tests and by sessions of the protocol, by file.

Compiles the two rooms once more, with clang's coverage, and links them into tandem-server and the test
programs of the release build. What only a process reaches, the program's options and orders, counts by the
tests of server's processes. Seeds whose sessions reach a branch that neither a kept seed nor one before them
reached are named, to be added to tests/simulation/protocol_seeds.txt.

    coverage.py [--jobs N] [--seeds N] [--first-seed N]    needs a release build of all that it names
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/support"))
import relinked  # noqa: E402

OUT = ROOT / "build/coverage"
COVERAGE = "-fprofile-instr-generate -fcoverage-mapping"
# The lines that must be reached, of a hundred.
LEAST = 95.0


def by_clang(line):
    """A compile or link of g++ as one of clang, which can not read g++'s precompiled headers."""
    line = re.sub(r"^(: && )?(\S*ccache )?\S*/(c|g)\+\+", r"\1\2clang++", line)
    return re.sub(r" -Winvalid-pch| -fpch-preprocess| -include \S*cmake_pch\.hxx", "", line)


def build(programs, jobs):
    OUT.mkdir(parents=True, exist_ok=True)
    commands = {program: relinked.commands_of(f"bin/{program}") for program in programs}
    compiles, links = {}, []
    for program, lines in commands.items():
        objects, replaced = [], []
        for output, line in lines.items():
            compiled = relinked.compiled_by(line)
            if not compiled or not any(str(source).startswith((f"{ROOT}/server/", f"{ROOT}/sync/"))
                                       for source in relinked.sources_in(compiled)):
                continue
            name = str(compiled).replace(f"{ROOT}/", "").replace("/", "_")
            objects.append(OUT / f"{name}.o")
            replaced.append(output)
            compiles[compiled] = by_clang(relinked.to_output(line, objects[-1])).replace(
                " -c ", f" {COVERAGE} -O1 -c ")
        link = relinked.link_of(lines, f"bin/{program}", OUT / program, objects)
        # Objects that the link names itself, as main's, would be taken before those that count.
        link = " ".join(word for word in link.split(" ") if word not in replaced)
        # What g++'s test wants of an inline function that clang has not kept comes from the library's object.
        links.append(by_clang(link).replace(" -o ", f" {COVERAGE} -Wl,--allow-multiple-definition -o ", 1))
    relinked.run_all(compiles.values(), jobs)
    relinked.run_all(links, jobs)


def run(program, arguments, variables):
    environment = dict(os.environ, LLVM_PROFILE_FILE=str(OUT / f"{program}.profraw"), **variables)
    done = subprocess.run([str(OUT / program), "--gtest_brief=1", *arguments], env=environment,
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program} failed\n{done.stdout[-4000:]}{done.stderr[-1000:]}")


def run_processes():
    """Server's tests of the program itself, on the one that is built here."""
    tandem = OUT / "tandem"
    tandem.unlink(missing_ok=True)
    tandem.symlink_to(relinked.BUILD / "bin/tandem")
    environment = dict(os.environ, LLVM_PROFILE_FILE=str(OUT / "tandem-server-%p.profraw"))
    for test in sorted((ROOT / "tests/server").glob("*_test.py")):
        done = subprocess.run([sys.executable, str(test), "--bin", str(OUT)], env=environment,
                              capture_output=True, text=True)
        if done.returncode != 0:
            print(f"{test.name} failed, so that what it reaches may be missing here:\n{done.stderr[-500:]}")


def lines_reached(programs):
    """(lines, reached) by file that is compiled for one of the programs."""
    profile = OUT / "all.profdata"
    raw = [str(path) for path in OUT.glob("*.profraw") if path.stat().st_size > 0]
    subprocess.run(["llvm-profdata", "merge", "-failure-mode=all", "-o", str(profile), *raw], check=True)
    rest = [argument for program in programs[1:] for argument in ("-object", str(OUT / program))]
    done = subprocess.run(["llvm-cov", "export", "-summary-only", f"-instr-profile={profile}",
                           str(OUT / programs[0]), *rest], capture_output=True, text=True, check=True)
    files = {}
    for entry in json.loads(done.stdout)["data"][0]["files"]:
        name = os.path.relpath(entry["filename"], ROOT)
        if name.startswith(("server/", "sync/")):
            lines = entry["summary"]["lines"]
            files[name] = (lines["count"], lines["covered"])
    return files


def report(files):
    for name, (count, covered) in sorted(files.items(), key=lambda each: each[1][1] / max(1, each[1][0])):
        print(f"{100.0 * covered / max(1, count):6.1f} %  {covered:5} of {count:5}  {name}")
    for room in ("server/", "sync/", ""):
        count = sum(lines for name, (lines, _) in files.items() if name.startswith(room))
        covered = sum(lines for name, (_, lines) in files.items() if name.startswith(room))
        share = 100.0 * covered / count
        print(f"{share:6.2f} %  of the lines of {room or 'both'}")
    return share


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--first-seed", type=int, default=1)
    arguments = parser.parse_args()
    tests = ["tests_simulation", "tests_server", "tests_sync"]
    programs = [*tests, "tandem-server"]
    build(programs, arguments.jobs)
    for old in OUT.glob("*.profraw"):
        old.unlink()
    new = OUT / "new_seeds.txt"
    new.unlink(missing_ok=True)
    run("tests_simulation", ["--gtest_filter=*ProtocolSessions*-*Minimised*"],
        {"TANDEM_PROTOCOL_SEEDS": str(arguments.seeds), "TANDEM_FIRST_SEED": str(arguments.first_seed),
         "TANDEM_PROTOCOL_CORPUS": str(new)})
    for program in tests[1:]:
        run(program, [], {})
    run_processes()
    share = report(lines_reached(programs))
    if new.exists():
        print("seeds that reach new branches:", " ".join(new.read_text().split()))
    if share < LEAST:
        print(f"less than {LEAST} % of the lines are reached")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
