#!/usr/bin/env python3
"""Searches ownership.pml with spin: no assertion may fail as it stands, one must with each of its mutations.

The searches are bounded in time, not exhaustive: depth first in the order of the text, then in random orders. Minutes; needs
Debian's package spin. Not among the tests that tests/run runs.
"""
import argparse
import os
import shutil
import subprocess
import sys
import tempfile

MUTATIONS = ["EPOCH_IN_MEMORY", "NO_EPOCH_CHECK", "EARLY_REGRANT", "NO_RECLAIM", "NO_HEIR", "NO_RECOVERY"]
MODEL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ownership.pml")


def build(folder, parts, mutation, shuffled):
    definitions = [f"-DPARTS={parts}"] + ([f"-D{mutation}"] if mutation else [])
    subprocess.run(["spin", *definitions, "-a", MODEL], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    flags = ["-O2", "-w", "-DSAFETY", "-DBITSTATE"] + (["-DT_RAND"] if shuffled else [])
    subprocess.run(["cc", *flags, "-o", "pan", "pan.c"], cwd=folder, check=True)


def failure(folder, arguments, seconds):
    """The assertion that failed, or None."""
    try:
        done = subprocess.run(["./pan", "-w26", "-n", *arguments], cwd=folder, timeout=seconds,
                              stdout=subprocess.PIPE, text=True)
    except subprocess.TimeoutExpired:
        return None
    for line in done.stdout.splitlines():
        if "assertion violated" in line:
            return line.split("assertion violated", 1)[1].strip()
        if "error:" in line and "max search depth" not in line:
            sys.exit(f"check_protocol: pan: {line}")
    return None


def search(parts, mutation, seconds):
    with tempfile.TemporaryDirectory() as folder:
        build(folder, parts, mutation, shuffled=False)
        found = failure(folder, ["-m800"], seconds)
        if found:
            return found
        build(folder, parts, mutation, shuffled=True)
        for seed in range(1, 5):
            found = failure(folder, [f"-m{150 + 50 * parts}", f"-RS{seed}"], seconds)
            if found:
                return found
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=15.0, help="of each search, of which there are five a model")
    seconds = parser.parse_args().seconds
    if shutil.which("spin") is None:
        sys.exit("check_protocol: spin is not installed (Debian's package spin)")
    bad = 0
    for parts in (1, 2):
        found = search(parts, None, seconds)
        print(f"{parts} part{'s' if parts > 1 else ''}, as it stands: {found or 'nothing fails'}", flush=True)
        bad += found is not None
    for mutation in MUTATIONS:
        found = search(2 if mutation == "NO_RECOVERY" else 1, mutation, 2 * seconds)
        print(f"{mutation}: {'fails: ' + found if found else 'NOT NOTICED'}", flush=True)
        bad += found is None
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
