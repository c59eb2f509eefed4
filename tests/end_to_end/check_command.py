"""What the tests of commands share: the sample scenes, where the commands are, `tandem check`, and what was
expected in vain."""
import argparse
import pathlib
import subprocess

SCENES = pathlib.Path(__file__).resolve().parent.parent.parent / "assets" / "scenes"
failed = []


def expect(true, what):
    if not true:
        failed.append(what)


def run(binaries, *arguments):
    return subprocess.run([binaries / "tandem", "check", *arguments], capture_output=True, text=True)


def binaries_of_command_line():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    return parser.parse_args().bin


def report():
    """Prints what failed; the exit code."""
    for what in failed:
        print("FAILED:", what)
    return 1 if failed else 0
