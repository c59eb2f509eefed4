#!/usr/bin/env python3
"""tandem-server as a process: what it prints, records, and says when its disk fails.

    python3 tests/server/program_test.py --bin build/release/bin
"""
import resource
import shutil
import subprocess
import sys

from server_process import SCENE, Server, run, wait_for

DISK_LIMIT = 4096  # bytes a file, when the disk is to fail


def an_expired_link_is_replaced(binaries, folder):
    with Server(binaries, folder, "--token-lifetime", "1", "--invite", "instructor=0") as server:
        wait_for(lambda: len(set(server.links("observer"))) >= 2, "a new link is printed")
        assert server.links("instructor") == []
    assert server.code == 0, server.code


def a_recording_is_begun_and_an_orderly_end_is_silent(binaries, folder):
    with Server(binaries, folder, "--quiet", "--record", folder / "recording") as server:
        wait_for(lambda: (folder / "recording").stat().st_size > 0, "the recording has its header")
    assert server.code == 0, server.code
    assert server.log() == "", server.log()


def a_recording_is_kept_when_the_same_command_is_given_again(binaries, folder):
    sizes = []
    for name in ("session.tandem", "session-2.tandem"):
        with Server(binaries, folder, "--record", folder / "session.tandem") as server:
            wait_for(lambda: (folder / name).stat().st_size > 0, "the recording has its header")
            with open(folder / name, "ab") as recording:
                recording.write(bytes(1000))  # stands for what a session records
        assert server.code == 0, server.code
        sizes.append((folder / "session.tandem").stat().st_size)
    assert sizes[0] == sizes[1] > 1000, sizes
    assert "session-2.tandem" in server.log(), server.log()


def wrong_numbers_of_places_are_refused_in_one_line(binaries, folder):
    folder.mkdir()
    program = binaries / "tandem-server"
    for options in (["--max-participants", "0"], ["--max-participants", "1024"], ["--max-participants", "x"],
                    ["--max-observers", "-1"], ["--max-observers", "1.5"], ["--max-observers", "960"],
                    ["--max-participants", "1000", "--max-observers", "24"]):
        done = subprocess.run([program, SCENE, "--data", folder / "data", *options], capture_output=True,
                              text=True, timeout=20)
        assert done.returncode == 2 and done.stdout == "", (options, done)
        assert len(done.stderr.splitlines()) == 1 and options[-2] in done.stderr, (options, done.stderr)
    text = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=20).stdout
    assert "--max-participants" in text and "--max-observers" in text, text


def a_failing_disk_is_told_with_quiet_too(binaries, folder):
    with Server(binaries, folder, "--quiet") as server:
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (DISK_LIMIT, DISK_LIMIT))
        wait_for(lambda: "journal" in server.log(), "the failure is told")
    assert server.code == 1, server.code
    lines = server.log().splitlines()
    assert len(lines) == 1 and " error " in lines[0] and "session.db" in lines[0], lines


def a_disk_that_is_well_again_is_used_again(binaries, folder):
    with Server(binaries, folder) as server:
        before = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (DISK_LIMIT, before[1]))
        wait_for(lambda: "nothing is granted" in server.log(), "the failure is told")
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, before)
        wait_for(lambda: "parts are granted again" in server.log(), "the end of it is told")
    assert server.code == 0, server.code


def a_directory_that_is_gone_is_noticed_and_no_second_server_takes_its_path(binaries, folder):
    with Server(binaries, folder) as server:
        away = folder / "away"
        server.data.rename(away)
        wait_for(lambda: "removed under the running server" in server.log(), "it is noticed")
        code, _, error = server.order(SCENE, "--listen", "127.0.0.1:0", "--duration", "1")
        assert code == 2 and "in use by another" in error, error
        if server.data.exists():
            shutil.rmtree(server.data)
        away.rename(server.data)
        wait_for(lambda: "parts are granted again" in server.log(), "it goes on")
    assert server.code == 0, server.code


def damage_is_refused_then_recovered_and_a_backup_restored(binaries, folder):
    backup = folder / "backup"
    with Server(binaries, folder) as server:
        code, _, error = server.order("--backup", backup)
        assert code == 0, error
    assert server.code == 0, server.code
    (server.data / "session.db").unlink()
    code, _, error = server.order(SCENE, "--listen", "127.0.0.1:0", "--duration", "1")
    assert code == 2, error
    lines = [line for line in error.splitlines() if "tandem-server: " in line]
    assert len(lines) == 1 and "session.db" in lines[0] and "--recover" in lines[0], error
    for order, said in ((["--recover"], "epochs continue beyond"), (["--restore", backup], "restored")):
        code, out, error = server.order(*order)
        assert code == 0 and said in out, (out, error)
        with Server(binaries, folder) as again:
            pass
        assert again.code == 0, again.code


if __name__ == "__main__":
    sys.exit(run(an_expired_link_is_replaced, a_recording_is_begun_and_an_orderly_end_is_silent,
                 a_recording_is_kept_when_the_same_command_is_given_again,
                 wrong_numbers_of_places_are_refused_in_one_line, a_failing_disk_is_told_with_quiet_too,
                 a_disk_that_is_well_again_is_used_again,
                 a_directory_that_is_gone_is_noticed_and_no_second_server_takes_its_path,
                 damage_is_refused_then_recovered_and_a_backup_restored))
