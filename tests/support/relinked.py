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


def compile_of(commands, source):
    """The command that compiles a source, given by its path in the project."""
    return next(line for line in commands.values() if line.endswith(f" -c {ROOT}/{source}"))


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
