"""Compares reading scans and making meshes with trimesh, Open3D and MeshLab (pymeshlab).

    VENV/bin/python benches/peers/read.py [--folder FOLDER] [--runs N] [--ours PROGRAM]

`run.py` explains how to make VENV. The script prints Markdown tables. It writes the scan, which
has a million points and two million triangles, to FOLDER (default: target/peers) the first time.
PROGRAM is a built examples/measure. The script needs Linux.

Every task runs N times (default: 3) in its own process, and each figure is the smallest of its
runs. CPU seconds are the user and system time of all threads, including the start and the end of
the process. MB are 10^6 bytes of peak resident memory. "Less import" means minus the cost of a
process that only imports the tool.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent))
import made

OURS = "scan2step"
PEERS = ["trimesh", "open3d", "pymeshlab"]
FORMATS = ["ply", "glb", "stl", "obj"]
TASKS = ["read", "mesh"]
FIGURES = ["cpu_s", "wall_s", "peak_rss_mb"]
UNITS = ["CPU s", "wall s", "peak MB"]


def main(given=None):
    options = arguments(given)
    files = scans(options.folder)
    ours = options.ours or made.built("measure")
    jobs = [(tool, "import", "") for tool in [OURS, *PEERS]]
    jobs += [(tool, task, end) for end in FORMATS for tool in [OURS, *PEERS] for task in TASKS]
    best = {}
    for run in range(options.runs):
        for job in jobs:
            print(f"run {run + 1}:", *job, file=sys.stderr)
            found = measure(command(job, ours, files))
            best[job] = least(best.get(job, found), found)
    report(best, options.runs)


def arguments(given):
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("--folder", type=Path, default=made.ROOT / "target" / "peers")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--ours", type=Path)
    return parser.parse_args(given)


def scans(folder):
    files = {ending: folder / f"scan.{ending}" for ending in FORMATS}
    if not all(file.exists() for file in files.values()):
        subprocess.run([sys.executable, HERE / "scan.py", folder], check=True, stdout=sys.stderr)
    return files


def command(job, ours, files):
    tool, task, ending = job
    file = [files[ending]] if ending else []
    if tool == OURS:
        return [ours, *file] + (["--mesh"] if task == "mesh" else [])
    return [sys.executable, HERE / "read_peers.py", tool, task, *file]


def measure(command):
    """The output of the command with its CPU and wall-clock time."""
    begun = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {process.returncode}")
    found = json.loads(printed.splitlines()[-1])
    return found | {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall_s}


def least(one, other):
    return one | {figure: min(one[figure], other[figure]) for figure in FIGURES}


def report(best, runs):
    versions = ", ".join(f"{peer} {importlib.metadata.version(peer)}" for peer in PEERS)
    python = platform.python_version()
    print(f"{versions}; Python {python}; {os.cpu_count()} CPUs; least of {runs} runs.")
    print("\n## Import alone\n")
    row(["tool", *UNITS])
    row(["---"] + ["--:"] * 3)
    for tool in [OURS, *PEERS]:
        row([tool] + [shown(figure, best[tool, "import", ""][figure]) for figure in FIGURES])
    table("Whole process", best)
    table("Less import", {job: less_import(best, job) for job in best})
    print("\n## What came out\n")
    read = ["vertices", "triangles"]
    mesh = [*read, "components", "loops", "manifold"]
    row(["format", "tool"] + [f"{count} read" for count in read] + mesh)
    row(["---"] * 2 + ["--:"] * 7)
    for ending in FORMATS:
        for tool in [OURS, *PEERS]:
            found = [best[tool, "read", ending][count] for count in read]
            found += [best[tool, "mesh", ending][count] for count in mesh]
            row([ending, tool, *found])


def less_import(best, job):
    base = best[job[0], "import", ""]
    return {figure: best[job][figure] - base[figure] for figure in FIGURES}


def table(title, best):
    print(f"\n## {title} (in brackets: times ours)\n")
    row(["format", "tool"] + [f"{task} {unit}" for task in TASKS for unit in UNITS])
    row(["---"] * 2 + ["--:"] * 6)
    for ending in FORMATS:
        for tool in [OURS, *PEERS]:
            cells = [cell(best, tool, task, ending, figure) for task in TASKS for figure in FIGURES]
            row([ending, tool, *cells])


def cell(best, tool, task, ending, figure):
    value, ours = best[tool, task, ending][figure], best[OURS, task, ending][figure]
    text = shown(figure, value)
    return text if tool == OURS or figure == "wall_s" else f"{text} ({value / ours:.1f})"


def shown(figure, value):
    return f"{value:.0f}" if figure == "peak_rss_mb" else f"{value:.2f}"


def row(cells):
    print("|", " | ".join(map(str, cells)), "|")


if __name__ == "__main__":
    main()
