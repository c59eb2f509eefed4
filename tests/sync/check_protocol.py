#!/usr/bin/env python3
"""Searches ownership.pml with spin: no assertion may fail as it stands, its own one must with each of its
mutations.

Exhaustive, breadth first, so that what is found is a shortest history: three sites and one part, 11 events in
any order; two parts, 9 events; every mutation within that. Sampled: two parts and up to 200 events, depth
first in orders that seeds choose, until a table of 2^23 bits is full; one mutation must be noticed in that
way too. Nothing depends on time. About two minutes and 2 GB; needs Debian's package spin.
"""
import dataclasses
import os
import re
import shutil
import subprocess
import sys
import tempfile

MODEL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ownership.pml")
EXHAUSTIVE = {1: 11, 2: 9}  # events, by the number of parts
SAMPLED = {25: 1, 50: 2, 200: 3}  # seeds, by the number of events


@dataclasses.dataclass
class Mutation:
    name: str
    breaks: str  # what its assertion, and no other one, speaks of
    parts: int = 1


MUTATIONS = [Mutation("EPOCH_IN_MEMORY", "highest"), Mutation("NO_EPOCH_CHECK", "shown"),
             Mutation("EARLY_REGRANT", "ended"), Mutation("NO_RECLAIM", "ended"),
             Mutation("NO_HEIR", "engaged"),
             Mutation("NO_RECOVERY", "recovering", parts=2)]


@dataclasses.dataclass
class Outcome:
    failed: str  # the assertion, or nothing
    states: int
    depth: int

    def __str__(self):
        events = f"{self.depth} events, {self.states} states"
        return f"{self.failed} fails after {events}" if self.failed else f"nothing fails, {events}"


def build(folder, parts, mutation, flags):
    definitions = [f"-DPARTS={parts}"] + ([f"-D{mutation}"] if mutation else [])
    subprocess.run(["spin", *definitions, "-a", MODEL], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cc", "-O2", "-w", "-DSAFETY", *flags, "-o", "pan", "pan.c"], cwd=folder, check=True)


def run(folder, arguments):
    text = subprocess.run(["./pan", "-n", *arguments], cwd=folder, stdout=subprocess.PIPE, text=True).stdout
    failed = re.search(r"assertion violated (.*) \(at depth (\d+)\)", text)
    states = re.search(r"(\d+) states, stored", text)
    errors = re.search(r"depth reached (\d+), errors: (\d+)", text)
    if not states or not errors or "out of memory" in text or (int(errors[2]) > 0) != (failed is not None):
        sys.exit("check_protocol: pan did not end as it should:\n" + text)
    # pan counts the steps before the one that fails; a breadth-first search of N goes no deeper than N.
    depth = int(failed[2]) + 1 if failed else int(errors[1])
    return Outcome(failed[1].strip() if failed else "", int(states[1]), depth)


def exhaustive(parts, mutation=None):
    with tempfile.TemporaryDirectory() as folder:
        build(folder, parts, mutation, ["-DBFS"])
        return run(folder, [f"-m{EXHAUSTIVE[parts]}", "-w24"])


def sampled(mutation=None):
    """Of each length, as far as nothing fails."""
    with tempfile.TemporaryDirectory() as folder:
        build(folder, 2, mutation, ["-DBITSTATE", "-DT_RAND"])
        for events, seed in SAMPLED.items():
            outcome = run(folder, [f"-m{events}", "-w23", f"-RS{seed}"])
            yield outcome
            if outcome.failed:
                return


def main():
    if shutil.which("spin") is None:
        sys.exit("check_protocol: spin is not installed (Debian's package spin)")
    bad = 0

    def judge(what, outcome, good):
        nonlocal bad
        print(f"{what}: {outcome}{'' if good else '  WRONG'}", flush=True)
        bad += not good

    for mutation in MUTATIONS:
        outcome = exhaustive(mutation.parts, mutation.name)
        judge(mutation.name, outcome, mutation.breaks in outcome.failed)
    *_, last = sampled("NO_RECLAIM")
    judge("NO_RECLAIM, sampled", last, "ended" in last.failed)
    for parts in EXHAUSTIVE:
        outcome = exhaustive(parts)
        judge(f"{parts} part{'s' if parts > 1 else ''}, as it stands", outcome, not outcome.failed)
    for outcome in sampled():
        judge("2 parts, sampled", outcome, not outcome.failed)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
