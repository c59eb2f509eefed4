"""Test programs of the release build, linked again with other objects in the place of some of their own."""
import concurrent.futures
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"


def commands_of(target):
    """The command that makes each output of a target of the release build, by output."""
    done = subprocess.run(["ninja", "-C", str(BUILD), "-t", "commands", target], capture_output=True,
                          text=True, check=True)
    named = [(re.search(r" -o (\S+)", line), line) for line in done.stdout.splitlines()]
    return {match[1]: line for match, line in named if match}


def compiled_by(line):
    """The source that a command compiles, or None of one that compiles nothing."""
    found = re.search(r" -c (\S+)$", line)
    return found and pathlib.Path(found[1])


def sources_in(compiled):
    """The sources compiled with one: those that CMake's file of a unity build includes, or itself alone."""
    if compiled.parent.name != "Unity":
        return [compiled]
    return [pathlib.Path(name) for name in re.findall(r'^#include "(.+)"$', compiled.read_text(), re.M)]


def compile_of(commands, source):
    """What is compiled for a source, given by its path in the project, and the command that does so."""
    for line in commands.values():
        compiled = compiled_by(line)
        if compiled and ROOT / source in sources_in(compiled):
            return compiled, line
    sys.exit(f"nothing compiles {source}")


def to_output(line, output):
    """The command with another output, and without the list of headers that ninja wants."""
    return re.sub(r" -MD -MT \S+ -MF \S+", "", re.sub(r" -o \S+", f" -o {output}", line))


def link_of(commands, program, output, objects):
    """The command that links a program with `objects` before its libraries, whose own are then not taken."""
    line = re.sub(r" && cd .*$", "", commands[program])
    return re.sub(r" -o \S+", f" -o {output} " + " ".join(map(str, objects)), line)


def run_all(lines, jobs):
    """Runs the commands side by side; ends the program at one that fails."""
    def run(line):
        return line, subprocess.run(line, shell=True, cwd=BUILD, capture_output=True, text=True)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for line, done in pool.map(run, lines):
            if done.returncode != 0:
                sys.exit(f"{line}\n{done.stdout}{done.stderr}")
