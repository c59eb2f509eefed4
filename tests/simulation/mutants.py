#!/usr/bin/env python3
"""Plants mistakes, one for each class of faults, and shows that sessions of that class find each of them.

Copies the sources named below, with every mistake in them behind a switch, into build/mutants, compiles the
copies and links one tests_simulation with them: the programs that people use never hold a mistake.

    mutants.py [--jobs N] [CLASS...]     needs a release build of tests_simulation
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/support"))
import relinked  # noqa: E402

OUT = ROOT / "build/mutants"

# A site that hears nothing for 1.7 s connects anew, and publishes nothing meanwhile. That hides a mistake in
# its lease of 1.95 s: in these classes it waits on, which breaks no rule by itself.
WAITS = {"serverPaused", "drift", "oneWayCuts", "blackouts", "delayPerSite", "bursts", "slowUplinks"}
WAITING = ("client/session/server_connection.cpp",
           "if (stage_ == Stage::ready) return pings_.serverIsSilent();",
           "if (stage_ == Stage::ready) return !tandem_waits && pings_.serverIsSilent();")

# (class of faults, what is wrong, [(source, text, the same with the mistake)]). M: this mistake is on.
MUTANTS = [
    ("serverKilled", "a restarted server forgets who owned what", [(
        "sync/replica/ownership_table.cpp",
        "    part.record = record;\n    if (record.owner == kNoSite) continue;",
        "    part.record = record;\n    if (M) part.record.owner = kNoSite;\n"
        "    if (M || record.owner == kNoSite) continue;")]),
    ("serverPaused", "the server counts leases before it hears what came meanwhile, and a site none", [
        ("server/session.cpp", "  receiveEvents();\n  fanOut.flush();",
         "  if (M) runTimers();\n  receiveEvents();\n  fanOut.flush();"),
        ("sync/replica/ownership_view.cpp", "return state_->everRenewed && now - state_->leaseFrom",
         "return M || (state_->everRenewed) && now - state_->leaseFrom")]),
    ("siteKilled", "a lease never runs out", [(
        "sync/replica/ownership_table.cpp", "return now - part.leaseFrom >= rules.serverLease();",
        "return !M && now - part.leaseFrom >= rules.serverLease();")]),
    ("sitePaused", "the server counts a quarter of the lease", [(
        "sync/replica/ownership_table.cpp", "return !(0) && now - part.leaseFrom >= rules.serverLease();",
        "return now - part.leaseFrom >= rules.serverLease() / (M ? 4 : 1);")]),
    ("leaves", "who leaves keeps its parts", [(
        "sync/replica/ownership_table.cpp",
        "for (const PartId id : owned) freed.push_back(state_->passOn(state_->parts[id]));\n  "
         "state_->sites",
        "for (const PartId id : owned)\n    if (!M) freed.push_back(state_->passOn(state_->parts[id]));\n"
        "  state_->sites")]),
    ("revokes", "co-holders outlive a revocation", [(
        "sync/replica/ownership_table.cpp", "  state_->coHolders.removeAll(id);",
        "  if (!M) state_->coHolders.removeAll(id);")]),
    ("resets", "a part is put back in its old epoch", [(
        "sync/replica/ownership_table.cpp",
        "  state_->beginEpoch(part);\n  part.record.worldFromPart = part.atRest;",
        "  if (!M) state_->beginEpoch(part);\n  part.record.worldFromPart = part.atRest;")]),
    ("diskFails", "who is denied learns of a grant that was not kept", [(
        "server/part_service.cpp", "  if (part < count()) record.worldFromPart = "
         "table_.part(part).worldFromPart;",
        "  if (M && part < count()) return table_.part(part);\n"
        "  if (part < count()) record.worldFromPart = table_.part(part).worldFromPart;")]),
    ("diskSlow", "answers do not wait for the disk", [(
        "server/publisher.cpp", "std::make_shared<const sync::ControlMessage>(std::move(message)), "
         "appended_);",
        "std::make_shared<const sync::ControlMessage>(std::move(message)), M ? 0 : appended_);")]),
    ("tornWrites", "half a record is believed", [(
        "client/simulation/faulty_journal.cpp", "    keep(pending_.front().record);\n    "
         "pending_.pop_front();\n  }\n"
        "  if (lying_)",
        "    if (auto* part = std::get_if<sync::PartRecord>(&pending_.front().record); M && part && "
         "part->epoch > 1)\n"
        "      --part->epoch;\n    keep(pending_.front().record);\n    pending_.pop_front();\n  }\n "
         " if (lying_)")]),
    ("bitRot", "a recovery raises no epoch", [(
        "client/simulation/faulty_journal.cpp", "record.epoch = entry.second + 1;",
        "if (!M) record.epoch = entry.second + 1;")]),
    ("lyingDisk", "nobody notices that the journal has lost its end", [(
        "client/simulation/faulty_journal.cpp", "    contents_ = onDisk_;\n    damaged_ = true;",
        "    contents_ = onDisk_;\n    damaged_ = !M;")]),
    ("drift", "a site adds the drift of clocks instead of taking it off", [(
        "sync/replica/ownership_view.cpp", "now - state_->leaseFrom < state_->rules.siteLease();",
        "now - state_->leaseFrom < (M ? state_->rules.serverLease() + state_->rules.margin : "
        "state_->rules.siteLease());")]),
    ("driftBeyondBound", "states of any owner and epoch are passed on and applied", [
        ("sync/replica/ownership_table.cpp",
         "if (part.record.owner != site || site == kNoSite || part.record.epoch != state.epoch) "
          "return false;",
         "if (!M && (part.record.owner != site || site == kNoSite || part.record.epoch != "
          "state.epoch)) return false;"),
        ("sync/replica/ownership_view.cpp", "  if (from == state_->self) return Verdict::ownPart;\n",
         "  if (from == state_->self) return Verdict::ownPart;\n  if (M) return Verdict::accepted;\n")]),
    ("wallClock", "a token is forgotten when it has expired by a wall clock that is wrong", [(
        "server/site_admission.cpp", "  dropSilent();\n  relist();\n",
        "  dropSilent();\n  relist();\n  static std::int64_t last = 0;\n"
        "  const std::int64_t wall = ground_.context.unixNow();\n"
        "  if (M && wall > last + 3600) usedNonces_.clear();\n  last = wall;\n")]),
    ("observers", "an observer is granted parts", [(
        "sync/replica/ownership_table.cpp",
        "  Denial decideGrab(SiteId site, Role role, PartEntry& part, Micros now, bool& changed) {\n"
        "    if (role == Role::observer)",
        "  Denial decideGrab(SiteId site, Role role, PartEntry& part, Micros now, bool& changed) {\n"
        "    if (!M && role == Role::observer)")]),
    ("lateJoiners", "a newcomer is not told where parts are", [(
        "server/site_admission.cpp", "  rest = ground_.parts.table().records();",
        "  if (!M) rest = ground_.parts.table().records();")]),
    ("oneWayCuts", "whatever arrives renews a site's lease", [(
        "client/session/state_receiving.cpp", "  ++counts_.updates;",
        "  ++counts_.updates;\n  if (M) ownership_.view().renewed(clock_.now());")]),
    ("blackouts", "a site publishes without a lease", [(
        "sync/replica/ownership_view.cpp", "return owns(part) && leaseValid(now) && !needsReclaim(part);",
        "return owns(part) && (M || (leaseValid(now) && !needsReclaim(part)));")]),
    ("delayPerSite", "a lease runs from the arrival of the pong", [(
        "client/session/server_connection.cpp", "renewed(message.siteTime, clock_.now());",
        "renewed(M ? clock_.now() : message.siteTime, clock_.now());")]),
    ("delaySteps", "an older state is applied", [(
        "sync/replica/ownership_view.cpp", "if (entry.hasSequence && state.sequence <= entry.sequence)",
        "if (!M && entry.hasSequence && state.sequence <= entry.sequence)")]),
    ("bursts", "a part whose lease has lapsed is published again at once", [(
        "sync/replica/ownership_view.cpp",
        "bool OwnershipView::needsReclaim(PartId part) const { return owns(part) &&",
        "bool OwnershipView::needsReclaim(PartId part) const { return !M && owns(part) &&")]),
    ("slowUplinks", "a site publishes without a lease", [(
        "sync/replica/ownership_view.cpp", "return state_->everRenewed && now - state_->leaseFrom",
        "return M || (state_->everRenewed) && now - state_->leaseFrom")]),
    ("losses", "a difference is added to another baseline than it was taken from", [
        ("sync/wire/state_receiver.cpp", "    if (baseline == nullptr) return Outcome::noBaseline;",
         "    if (M && baseline == nullptr && !stream->kept.empty()) baseline = &stream->kept.front();\n"
         "    if (baseline == nullptr) return Outcome::noBaseline;"),
        ("sync/wire/state_receiver.cpp", "check.value() != expected", "!M && check.value() != expected"),
        ("sync/wire/state_sender.cpp", "    if (!kept.acknowledged || distance == 0 ||",
         "    if ((!M && !kept.acknowledged) || distance == 0 ||")]),
    ("duplicates", "a state is applied twice", [(
        "sync/replica/ownership_view.cpp", "entry.hasSequence && state.sequence <= entry.sequence)",
        "entry.hasSequence && (M ? state.sequence < entry.sequence : state.sequence <= entry.sequence))")]),
    ("reordering", "a state is applied after a newer one", [(
        "sync/replica/ownership_view.cpp", "if (!(0) && entry.hasSequence &&", "if (!M && "
         "entry.hasSequence &&")]),
    ("malformed", "what is no message is passed over", [(
        "server/session.cpp", "    admission.refuse(peer, sync::Refusal::malformed, "
         "message.error().message);",
        "    if (!M) admission.refuse(peer, sync::Refusal::malformed, message.error().message);")]),
    ("replayed", "a token lets in twice", [(
        "server/site_admission.cpp", "if (usedNonces_.contains(ticket.nonce)) {",
        "if (!M && usedNonces_.contains(ticket.nonce)) {")]),
    ("escalated", "anybody commands", [(
        "server/instructor_commands.cpp", "if (peer.role != sync::Role::instructor) {",
        "if (!M && peer.role != sync::Role::instructor) {")]),
    ("floods", "a site may ask without end", [(
        "server/session.cpp", "if (budget.spend(context.now(), messages)) return;",
        "if (M || budget.spend(context.now(), messages)) return;")]),
    ("forged", "nobody checks a signature", [(
        "server/admission.cpp", "                                  key.open().data()) != 0)",
        "                                  key.open().data()) != 0 && !M)")]),
    ("forged", "an expired token lets in", [(
        "server/site_admission.cpp", "} else if (ticket->expires <= ground_.context.unixNow()) {",
        "} else if (!M && ticket->expires <= ground_.context.unixNow()) {")]),
]


def planted():
    """The sources with all mistakes in them, each behind its number."""
    source, text, mistake = WAITING
    whole = (ROOT / source).read_text()
    if whole.count(text) != 1:
        sys.exit(f"mutants.py: not once in {source}:\n{text}")
    texts = {source: whole.replace(text, mistake)}
    numbers = {}
    for number, (_, _, edits) in enumerate(MUTANTS, 1):
        for edit in edits:
            numbers.setdefault(edit, []).append(number)
    for number, (faults, _, edits) in enumerate(MUTANTS, 1):
        for source, text, mistake in edits:
            same = numbers[source, text, mistake]  # classes that share the mistake
            if same[0] != number:
                continue
            whole = texts.setdefault(source, (ROOT / source).read_text())
            # What an earlier mistake has changed is written with (0) for its switch.
            pattern = re.escape(text).replace(re.escape("(0)"), r"\(tandem_mutant == \d+\)")
            found = list(re.finditer(pattern, whole))
            if len(found) != 1:
                sys.exit(f"mutants.py: {faults}: found {len(found)} times in {source}, not once:\n{text}")
            at = found[0]
            switch = " || ".join(f"tandem_mutant == {n}" for n in same)
            mistake = re.sub(r"\bM\b", f"({switch})", mistake)
            if "(tandem_mutant" in at[0] and "!(0)" in text:  # keeps the earlier switch beside the new one
                earlier = re.search(r"\(tandem_mutant == \d+\)", at[0])[0]
                mistake = mistake.replace("return ", f"return !{earlier} && ", 1) if "return " in mistake \
                    else mistake.replace("if (", f"if (!{earlier} && ", 1)
            whole = whole[:at.start()] + mistake + whole[at.end():]
            texts[source] = whole
    return texts


def write(copy, text):
    if not copy.exists() or copy.read_text() != text:
        copy.write_text(text)


def build(jobs):
    OUT.mkdir(parents=True, exist_ok=True)
    commands = relinked.commands_of("bin/tests_simulation")
    edited = {}  # each file that is compiled, with its command and the copies of the sources in it
    for source, text in planted().items():
        copy = OUT / source.replace("/", "_")
        # Behind the includes' own names, so that no header is changed.
        write(copy, "extern int tandem_mutant;\nextern bool tandem_waits;\n" + text)
        compiled, line = relinked.compile_of(commands, source)
        edited.setdefault(compiled, (line, {}))[1][ROOT / source] = copy
    compiles, objects = [], []
    for compiled, (line, copies) in edited.items():
        copy = copies.get(compiled)
        if copy is None:  # a room compiled as one source: the same file with the copies in it
            copy = OUT / f"{compiled.parents[1].stem}.cpp"
            write(copy, "".join(f'#include "{copies.get(one, one)}"\n'
                                for one in relinked.sources_in(compiled)))
        objects.append(copy.with_suffix(".o"))
        compiles.append(relinked.to_output(line.replace(str(compiled), str(copy)), objects[-1]))
    switch = OUT / "switch.cpp"
    switch.write_text('#include <cstdlib>\nint tandem_mutant = std::getenv("TANDEM_MUTANT") == nullptr ? 0 : '
                      'std::atoi(std::getenv("TANDEM_MUTANT"));\n'
                      'bool tandem_waits = std::getenv("TANDEM_WAITS") != nullptr;\n')
    objects.append(OUT / "switch.o")
    compiles.append(f"g++ -c {switch} -o {objects[-1]}")
    relinked.run_all(compiles, jobs)
    relinked.run_all([relinked.link_of(commands, "bin/tests_simulation", OUT / "tests_mutants", objects)], 1)


def find(number):
    """The seed that finds a mistake, if the same seed breaks no rule without it."""
    number, found, output = search(number, number, {})
    if found is None:
        return number, found, output
    seed = re.search(r"found by seed (\d+)", found)[1]
    control = search(number, 0, {"TANDEM_FIRST_SEED": seed, "TANDEM_PROTOCOL_SEEDS": "1"})
    if control[1] is not None:
        return number, None, "without the mistake too: " + control[1]
    return number, found, output


def search(number, mutant, extra):
    environment = dict(os.environ, TANDEM_MUTANT=str(mutant), TANDEM_FAULTS=MUTANTS[number - 1][0], **extra)
    if MUTANTS[number - 1][0] in WAITS:
        environment["TANDEM_WAITS"] = "1"
    done = subprocess.run([str(OUT / "tests_mutants"), "--gtest_filter=ProtocolMutant.IsFound"],
        env=environment,
                          capture_output=True, text=True)
    found = re.search(r"found by seed .*", done.stdout)
    if found and done.returncode == 0:
        return number, found[0], done.stdout
    seeds = re.findall(r"^seed (\d+)$", done.stdout, re.M)
    broken = re.search(r"broken invariant: .*", done.stderr)
    if seeds and broken:  # an assertion of the server or a site
        return number, f"found by seed {seeds[-1]}: {broken[0]}", done.stdout
    return number, None, done.stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--check", action="store_true", help="only that each place is in the sources")
    parser.add_argument("classes", nargs="*")
    arguments = parser.parse_args()
    if arguments.check:
        return 0 if planted() else 1
    build(arguments.jobs)
    wanted = [n for n, m in enumerate(MUTANTS, 1) if not arguments.classes or m[0] in arguments.classes]
    missed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for number, found, output in pool.map(find, wanted):
            faults, what, _ = MUTANTS[number - 1]
            print(f"{faults:17} {what}: {found or 'NOT FOUND'}", flush=True)
            if found is None:
                missed += 1
                print(output[-1500:])
    print(f"{len(wanted) - missed} of {len(wanted)} planted mistakes were found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
