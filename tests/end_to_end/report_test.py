#!/usr/bin/env python3
"""Runs `tandem report --quick` as a user would: one page that needs nothing else, its figures beside it, no allocation.

    python3 tests/end_to_end/report_test.py --bin build/release/bin
"""
import argparse
import html.parser
import json
import pathlib
import subprocess
import sys
import tempfile

VOID = {"meta", "br"}


class Page(html.parser.HTMLParser):
    """Collects the elements, the attributes that would load something, and the embedded data."""

    def __init__(self):
        super().__init__()
        self.open, self.count, self.loads, self.data, self.inside = [], {}, [], "", False

    def handle_starttag(self, tag, attributes):
        self.count[tag] = self.count.get(tag, 0) + 1
        self.loads += [a for a, _ in attributes if a in ("src", "href")]
        self.inside = tag == "script"
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.count[tag] = self.count.get(tag, 0) + 1

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            raise ValueError(f"</{tag}> closes nothing")
        self.inside = False

    def handle_data(self, data):
        if self.inside:
            self.data += data


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    binaries = parser.parse_args().bin
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [binaries / "tandem", "report", "--quick", "--out", folder / "r.html", "--json", folder / "r.json"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=250)
        assert run.returncode == 0, run.stderr
        figures = json.loads((folder / "r.json").read_text())
        page = Page()
        page.feed((folder / "r.html").read_text())
        page.close()
        assert not page.open and not page.loads, (page.open, page.loads)
        assert json.loads(page.data) == figures
        experiments = {e["id"]: {s["id"]: s for s in e["settings"]} for e in figures["experiments"]}
        assert page.count["table"] > len(experiments) and page.count["svg"] >= 4, page.count
        assert all(s["allocations"] in (0, None) for e in experiments.values() for s in e.values())
        assert experiments["plane"]["tandem"]["error_share"]["p99"] < 1e-6
        assert experiments["plane"]["one-plane-double"]["error_share"]["max"] > 0.2
        assert experiments["sphere-10k"]["shading"]["error_share"]["p99"] < 1e-3
        assert experiments["friction"]["tandem"]["error_share"]["p99"] < 5e-3
        single = {f["id"]: f for f in figures["figures"]}
        assert single["friction-sphere-mean"]["value"] < 0.5 and "refit-100k" in single, single
        beside = (binaries / "bench_peers").exists()
        assert bool(figures["peers"]) == beside and ("embree" in experiments["plane"]) == beside
        failing = subprocess.run([*command, "--peers", "/bin/false"], capture_output=True, text=True, timeout=250)
        assert failing.returncode == 1 and "/bin/false" in failing.stderr, failing.stderr
    print(f"{len(experiments)} experiments, {page.count['svg']} plots")


if __name__ == "__main__":
    sys.exit(main())
