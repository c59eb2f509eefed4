#!/usr/bin/env python3
"""The unit file of tandem-server: systemd accepts it, it exposes little, and the server runs within it.

    python3 tests/server/service_test.py --bin build/release/bin

What needs systemd-analyze or strace is left out, and says so, where they are not. Each check has a control
that must fail: a unit that is wrong, one that is open, and a filter of system calls that is too narrow.
"""
import os
import re
import shutil
import subprocess
import sys
import urllib.request

from server_process import ROOT, Server, Site, run, wait_for

UNIT = ROOT / "server" / "tandem-server.service.in"
THRESHOLD = 15  # tenths, of the exposure that systemd-analyze computes; 0 is the best, 100 the worst


def missing(*tools):
    absent = [tool for tool in tools if shutil.which(tool) is None]
    if absent:
        print("left out:", ", ".join(absent), "not installed", flush=True)
    return bool(absent)


def unit(binaries, folder, change=lambda text: text):
    """The unit as it is installed, with the program of the build."""
    folder.mkdir(exist_ok=True)
    path = folder / "tandem-server.service"
    path.write_text(change(UNIT.read_text().replace("@CMAKE_INSTALL_FULL_BINDIR@", str(binaries.resolve()))))
    return path


def analyze(*words):
    done = subprocess.run(["systemd-analyze", *map(str, words)], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


def systemd_accepts_the_unit(binaries, folder):
    if missing("systemd-analyze"):
        return
    code, out, error = analyze("verify", "--man=no", unit(binaries, folder))
    assert code == 0 and out + error == "", (out, error)
    for wrong in (lambda text: text.replace("Type=notify", "Type=notifies"),
                  lambda text: text.replace("RestrictNamespaces=", "RestrictNamespace="),
                  lambda text: text.replace("/tandem-server ${", "/no-such-program ${")):
        code, out, error = analyze("verify", "--man=no", unit(binaries, folder, wrong))
        assert code != 0 or error != "", "a wrong unit is accepted"


def the_unit_exposes_little(binaries, folder):
    if missing("systemd-analyze"):
        return
    security = ("security", "--offline=true", "--no-pager", f"--threshold={THRESHOLD}")
    code, out, error = analyze(*security, unit(binaries, folder))
    assert code == 0, out + error
    code, _, _ = analyze(*security, unit(binaries, folder, lambda text: re.sub(
        r"(?m)^(SystemCall|Capability|Protect|NoNew).*\n", "", text)))
    assert code != 0, "an open unit is accepted"


def settings(text, name):
    return [word for value in re.findall(rf"(?m)^{name}=(.*)$", text) for word in value.split()]


def forbidden_calls(text):
    """The system calls that the unit's filter, an allow list with exceptions, does not let through."""
    groups, name = {}, None
    for line in analyze("syscall-filter", "--no-pager")[1].splitlines():
        if line.startswith("@"):
            name = groups.setdefault(line.strip(), [])
        elif name is not None and line.strip() and "#" not in line:
            name.append(line.strip())

    def expanded(word):
        return {call for member in groups[word] for call in expanded(member)} if word in groups else {word}

    allowed = expanded("@default")
    for value in re.findall(r"(?m)^SystemCallFilter=(.*)$", text):
        for word in value.lstrip("~").split():
            allowed = allowed - expanded(word) if value.startswith("~") else allowed | expanded(word)
    return sorted(expanded("@known") - allowed)


def traced(text, trace):
    """strace that refuses the calls which the unit forbids, as its filter does, and notes sockets."""
    calls = ",".join("?" + call for call in forbidden_calls(text))
    return ["strace", "-D", "-f", "-qq", "--seccomp-bpf", "-o", trace, "-e", "signal=none",
            "-e", f"trace=?socket,{calls}", "-e", f"inject={calls}:error=EPERM"]


def can_trace(folder):
    folder.mkdir(exist_ok=True)
    done = subprocess.run(["strace", "-f", "--seccomp-bpf", "-o", folder / "probe", "true"],
                          capture_output=True, text=True, timeout=20)
    if done.returncode != 0:
        print("left out: no process may be traced here:", done.stderr.strip(), flush=True)
    return done.returncode == 0


def the_server_works_within_the_unit(binaries, folder):
    if missing("systemd-analyze", "strace") or not can_trace(folder):
        return
    text, trace = UNIT.read_text(), folder / "trace"
    options = ["--metrics", ":0", "--log", "json"]
    with Server(binaries, folder, *options, listen=":0", under=traced(text, trace)) as server:
        link = re.sub(r"(?<=//)[^/:]*", "127.0.0.1", server.order("--invite-now", "participant")[1])
        with Site(binaries, folder, link, "Ben") as ben:
            wait_for(lambda: "joined" in server.events(), "Ben has joined")
            assert server.order("--rotate-keys")[0] == 0
            port = re.search(r"metrics on 127\.0\.0\.1 port (\d+)", server.log()).group(1)
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/healthz", timeout=20) as answer:
                assert answer.status == 200
            assert server.order("--kick", "Ben")[0] == 0
            wait_for(lambda: ben.process.poll() is not None, "Ben has gone")
    assert server.code == 0, server.log()
    used = set(re.findall(r"socket\((AF_\w+)", trace.read_text()))
    assert used and used <= set(settings(text, "RestrictAddressFamilies")), used
    refused = set(re.findall(r"(\w+)\(.*\(INJECTED\)", trace.read_text()))
    if os.geteuid() == 0:
        refused.discard("fchown")  # of SQLite, which as root gives new files to the owner of the database
    assert not refused, f"the unit forbids what the server asks for: {refused}"


def a_filter_that_is_too_narrow_is_noticed(binaries, folder):
    if missing("systemd-analyze", "strace") or not can_trace(folder):
        return
    text = UNIT.read_text().replace("~@privileged", "~@network-io @privileged")
    server = Server(binaries, folder, under=traced(text, folder / "trace"))
    try:
        assert server.process.wait(20) != 0
    finally:
        server.stop()


if __name__ == "__main__":
    sys.exit(run(systemd_accepts_the_unit, the_unit_exposes_little, the_server_works_within_the_unit,
                 a_filter_that_is_too_narrow_is_noticed))
