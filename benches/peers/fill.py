"""Compares the fill with CGAL, MeshLib and MeshLab, and with the truth of virtual scans.

    VENV/bin/python benches/peers/fill.py [SCAN ...]

`run.py` explains how to make VENV. The script prints a Markdown table: the CPU seconds of
all threads for the fills alone, the holes left open, the added vertices, and their root mean
square distance from the true surface. All programs get the same mesh, which is the scan
smoothed by scan2step. scan2step also has the measured points, from which it computes the
noise. `benches/holes/peers.py` explains how the programs are called. The script needs Linux.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent))
import made

PEERS = ["cgal-c1", "cgal-c2", "meshlib", "meshlab"]
SCANS = ["paper8100", "roll40k", "relief250k"]
COLUMNS = ["scan", "program", "CPU s", "ratio", "left open", "vertices", "rms mm"]


def main(scans):
    print("\n| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for name in scans:
        with tempfile.TemporaryDirectory() as folder:
            beside(name, Path(folder))


def beside(name, folder):
    import numpy as np

    scan, out = made.scan(name, folder / "scan.ply"), folder / "filled.ply"
    run = subprocess.run([made.built("measure"), scan, "--fill", out], check=True, stdout=subprocess.PIPE)
    told = json.loads(run.stdout)
    count, cpu = told["vertices"], told["cpu_s"]["fill"]
    points, triangles = made.read_ply(out)
    row(name, "scan2step", cpu, cpu, 0, points[count:])
    given, filled = folder / "given.npz", folder / "filled.npz"
    np.savez(given, points=points[:count], triangles=triangles[: told["triangles"]])
    for peer in PEERS:
        filled.unlink(missing_ok=True)
        command = [sys.executable, "-B", HERE.parent / "holes" / "peers.py", "fill", peer, given, filled]
        run = subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE, text=True)
        if not filled.exists():
            said = (run.stderr.strip().splitlines() or [f"code {run.returncode}"])[-1]
            print(f"| {name} | {peer} | failed: {said[-80:]} |" + " |" * 4, flush=True)
            continue
        of_peer = np.load(filled)
        row(name, peer, float(of_peer["seconds"]), cpu, int(of_peer["refused"]), of_peer["points"][count:])


def row(name, program, seconds, ours, left, added):
    cells = [name, program, f"{seconds:.2f}", f"{seconds / ours:.1f}", left, f"{len(added):,}",
             f"{made.rms(name, added):.4f}" if len(added) else ""]
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or SCANS)
