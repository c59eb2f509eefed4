"""Judges no run during which the machine stood still.

A virtual machine may be put to sleep for a tenth of a second at any moment. A hand's loop that sleeps takes
its force away and finds its tool elsewhere, a script goes on meanwhile: what such a run shows is that nothing
breaks, not that a part was moved as far as it should have been. A run that fails is judged again if the
machine stood still during it, and counts as failed at once if it did not.
"""
import functools
import itertools
import threading
import time

STILL = 0.05  # s, as HandLoop::kStall
ATTEMPTS = 6
CALM = 2.0  # s without standing still, before a run is tried again
PATIENCE = 60.0  # s to wait for that


class Pulse(threading.Thread):
    """Notices when this process was not run for a while."""

    def __init__(self):
        super().__init__(daemon=True)
        self.missed = 0
        self.last_missed = time.monotonic()
        self.start()

    def run(self):
        before = time.monotonic()
        while True:
            time.sleep(0.005)
            now = time.monotonic()
            if now - before > STILL:
                self.missed += 1
                self.last_missed = now
            before = now

    def wait_for_calm(self):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < min(end, self.last_missed + CALM):
            time.sleep(0.05)


class Steady:
    """Runs a test until it passes, or fails while nothing stood still."""

    def __init__(self):
        self.pulse = Pulse()
        self.stalls = 0  # of hands' loops, as sites report them

    def judge(self, test, failures):
        """test(); `failures` are the exceptions by which it fails."""
        for attempt in range(ATTEMPTS):
            self.pulse.wait_for_calm()
            self.pulse.missed = self.stalls = 0
            try:
                return test()
            except failures as failure:
                if attempt + 1 == ATTEMPTS or self.pulse.missed + self.stalls == 0:
                    raise
                print(f"again, for the machine stood still ({self.pulse.missed} times here, "
                      f"{self.stalls} in hands): "
                      f"{failure}")


STEADY = Steady()


def steadily(test):
    """A test for server_process.run() that is judged so, each time in another folder."""
    @functools.wraps(test)
    def judged(binaries, folder):
        attempts = itertools.count()
        STEADY.judge(lambda: test(binaries, folder.with_name(f"{folder.name}_{next(attempts)}")),
                     AssertionError)
    return judged
