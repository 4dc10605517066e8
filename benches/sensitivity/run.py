#!/usr/bin/env python3
"""Measures how much results depend on each named constant: halves and doubles it, converts small
scans, and writes what changes to target/constants.md.

    benches/sensitivity/run.py FOLDER [--shared DIR] [--only PART[,PART]] [--enough N] [--most N] [--keep]

FOLDER keeps the build and the results, so that a stopped run continues where it was. Constants with
other values, scans or names are measured in a new folder. DIR has the real scans; without them only
virtual scans are measured, and the script says so. PART limits the run to constants with this in
their file or name; the others keep their figures in the page. With --enough, a constant is tried on
no more scans once N of them have changed, and with --most on no more than N. With 1 and 4 this
takes an hour on one core. --keep writes the constants that matter most to docs/constants.md. Nothing
but Python and cargo is needed.
"""

import argparse
import json
import os
import resource
import signal
import subprocess
from dataclasses import dataclass
from pathlib import Path

import build
import constants
import page
import scans

FACTORS = [0.5, 2.0]

# A run that takes this many times its usual time, and this many seconds more, hangs.
HANGS, SECONDS = 10, 5


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--shared", type=Path, default=build.ROOT.parent / "shared/scans/A")
    parser.add_argument("--only", default="")
    every = len(scans.REAL) + 5
    parser.add_argument("--enough", type=int, default=every)
    parser.add_argument("--most", type=int, default=every)
    parser.add_argument("--keep", action="store_true")
    arguments = parser.parse_args()
    program, varied = build.program(arguments.folder)
    inputs = scans.all_scans(arguments.folder / "scans", arguments.shared)
    usual = [measured(program, scan, arguments.folder) for scan in inputs]
    # The cheapest scans come first, because not all may be needed.
    order = sorted(range(len(inputs)), key=lambda i: usual[i]["seconds"])
    inputs, usual = [inputs[i] for i in order], [usual[i] for i in order]
    bench = Bench(program, inputs, usual, arguments)
    parts = arguments.only.split(",")
    for number, constant in enumerate(varied):
        if any(part in constant.key for part in parts):
            for factor in FACTORS:
                bench.vary(number, constant, factor)
    all_constants = constants.found(arguments.folder / "original")
    fixed = [c for c in all_constants if c not in varied]
    file = build.ROOT / "target/constants.md"
    before = file.read_text() if file.exists() else ""
    text = page.written(varied, fixed, inputs, usual, bench.results, before)
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    if arguments.keep:
        kept = build.ROOT / "docs/constants.md"
        kept.write_text(page.most_important(text, steers_nothing))


def steers_nothing(room, file, name):
    """Whether .ci/constants.txt has this constant."""
    rows = [line.split()[:2] for line in (build.ROOT / ".ci/constants.txt").read_text().splitlines()]
    file = Path(file)
    module = file.parent.name if file.stem == "mod" else file.stem
    return [room, name] in rows or [room, f"{module}::{name}"] in rows


@dataclass
class Bench:
    program: str
    inputs: list
    usual: list
    arguments: argparse.Namespace

    def __post_init__(self):
        self.results = Results(self.arguments.folder / "results.jsonl")

    def vary(self, number, constant, factor):
        """Converts the scans of which the conversion reads the constant, and keeps the figures."""
        changed = tried = 0
        for scan, before in zip(self.inputs, self.usual):
            if number not in before["read"]:
                continue
            if changed == self.arguments.enough or tried == self.arguments.most:
                break
            tried += 1
            key = (constant.key, factor, scan.name)
            if key not in self.results.rows:
                varied, seconds = (number, factor), before["seconds"]
                # Other constants change what `check` finds only if they change the file.
                is_checked = constant.room == "check"
                folder = self.arguments.folder
                after = measured(self.program, scan, folder, varied, seconds, is_checked)
                self.results.add(*key, after)
            changed += page.differs(before, self.results.rows[key])


class Results:
    """The figures by constant, factor and scan, in a file that grows."""

    def __init__(self, path):
        self.path, self.rows = path, {}
        if path.exists():
            for line in path.read_text().splitlines():
                *key, figures = json.loads(line)
                self.rows[tuple(key)] = figures

    def add(self, *row):
        self.rows[row[:-1]] = row[-1]
        with self.path.open("a") as file:
            file.write(json.dumps(row) + "\n")


def measured(program, scan, folder, varied=None, usual_seconds=10.0, is_checked=True):
    """The figures of a conversion, and of `check` with its CAD file. `varied` has the number and the
    factor of a constant."""
    cad, report, read = (folder / name for name in ["part.step", "report.json", "read"])
    for file in [cad, report, read]:
        file.unlink(missing_ok=True)
    environment = os.environ | {"RAYON_NUM_THREADS": "1"}
    if varied:
        environment |= {"VARIED": str(varied[0]), "FACTOR": str(varied[1])}
    else:
        environment["CONSTANTS_READ"] = str(read)
    limit = HANGS * usual_seconds + SECONDS
    command = [program, "convert", scan.path, cad, "--threads", "1", "--quiet", "--report", report]
    begun = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    code, _ = finished(command + scan.options, environment, limit)
    figures = {"exit": code, **of_report(report)}
    if is_checked and cad.exists():
        figures["check"] = of_check(program, cad, scan, environment, limit)
    figures["seconds"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begun
    if not varied:
        figures["read"] = sorted(set(map(int, read.read_text().split())))
    return figures


def of_check(program, cad, scan, environment, limit):
    """The exit code of `check`, and the root mean square distances in both directions."""
    needed = ["--units", "--component"]
    pairs = zip(scan.options, scan.options[1:])
    options = [text for pair in pairs if pair[0] in needed for text in pair]
    command = [program, "check", cad, scan.path, "--threads", "1", "--json", *options]
    code, output = finished(command, environment, limit)
    both = json.loads(output) if code in (0, 3) else {}
    return [code, *[both[d]["rms_mm"] for d in ("scan_to_face", "face_to_scan") if d in both]]


def finished(command, environment, limit):
    """The exit code of a command, or 'hangs' if it needs more CPU seconds than the limit, and its
    output. Time on the clock would depend on what else the computer does."""
    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (round(limit), round(limit) + 1))

    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    run = subprocess.run(command, env=environment, preexec_fn=limited, **pipes)
    stopped = run.returncode in (-signal.SIGXCPU, -signal.SIGKILL)
    return "hangs" if stopped else run.returncode, run.stdout


def of_report(path):
    """The figures of a report that show how good the face is."""
    if not path.exists():
        return {}
    report = json.loads(path.read_text())
    faces = report.get("components", [report])
    return {
        "bytes": [output["sha256"] for output in report["outputs"]],
        "rms": max(face["deviation"]["rms_mm"] for face in faces),
        "folds": sum(face["shape"]["folds"] + (face["fit"].get("folds") or 0) for face in faces),
        "points": sum(face["shape"]["control_points"] for face in faces),
        "loops": sum(len(face.get("trim", [])) for face in faces),
        "met": report["tolerance_met"],
        "hints": len(report["hints"]),
    }


if __name__ == "__main__":
    main()
