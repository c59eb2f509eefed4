#!/usr/bin/env python3
"""Runs `tandem report --quick` as a user would: one page that needs nothing else, its figures beside it, no
allocation.

    python3 tests/end_to_end/report_test.py --bin build/release/bin
"""
import html.parser
import json
import pathlib
import subprocess
import sys
import tempfile

from check_command import binaries_of_command_line

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
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [binaries / "tandem", "report", "--quick", "--out", folder / "r.html", "--json",
                   folder / "r.json"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=250)
        assert run.returncode == 0, run.stderr
        figures = json.loads((folder / "r.json").read_text())
        page = Page()
        text = (folder / "r.html").read_text()
        page.feed(text)
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
        held = {e["id"]: {s["id"]: s for s in e["settings"]} for e in figures["held"]}
        assert set(held) == {"held-peg", "held-slide", "held-plates", "held-inside"}, held.keys()
        for case, settings in held.items():
            assert {"tandem", "field-1-samples-4", "field-4-samples-1", "unrefined", "steps-1",
                    "queries-30"} <= \
                set(settings), (case, settings.keys())
            assert ("fcl" in settings) == beside, (case, settings.keys())
            assert settings["tandem"]["penetration_m"]["max"] < 20e-6, (case, settings["tandem"])
            assert settings["tandem"]["error_share"]["p99"] < 0.2, (case, settings["tandem"])
            assert settings["tandem"]["found_share"] > 0.99, (case, settings["tandem"])
            assert f"<h3>{next(e['title'] for e in figures['held'] if e['id'] == case)}" in text, case
        links = {e["id"]: {s["id"]: s for s in e["settings"]} for e in figures["links"]}
        assert set(links) == {"link-25ms", "link-100ms"}, links.keys()
        for case, (stiffness, apart, load) in {"link-25ms": (217, 2e-3, 1.2),
                                               "link-100ms": (66, 10e-3, 1.5)}.items():
            used = links[case]["link"]
            assert used["stable"] and used["created_j"] <= 1e-3, (case, used)
            assert used["hand_to_hand_n_m"] >= stiffness and used["wall_n_m"] >= 830, (case, used)
            assert used["apart_m"]["rms"] <= apart and used["leader_force_ratio"] <= load, (case, used)
            assert {"no-network", "plain-400", "plain-best",
                    "tank-best"} <= set(links[case]), (case, links[case].keys())
        assert not links["link-100ms"]["plain-400"]["stable"], links["link-100ms"]["plain-400"]
        assert "<h2>Across the network" in text and 'class="unstable"' in text
        failing = subprocess.run([*command, "--scenes", "plane", "--peers", "/bin/false"],
                                 capture_output=True, text=True, timeout=250)
        assert failing.returncode == 1 and "/bin/false" in failing.stderr, failing.stderr
    print(f"{len(experiments)} experiments, {page.count['svg']} plots")


if __name__ == "__main__":
    sys.exit(main())
