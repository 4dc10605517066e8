"""Fills the holes of real scans with scan2step, and judges what can be judged
without a true surface: cuts, topology, angles, seams. With pictures.

    VENV/bin/python benches/holes/real.py target/release/scan2step SCAN... [--pictures DIR]
        [--most N] [--work DIR]

Columns as in evaluate.py; 'sharp' are edges inside the fill whose faces turn by
more than 90 degrees.
"""

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import meshes
import run as runs
from evaluate import at_edges, cutting, number, percentiles, report
from pictures import draw

COLUMNS = ["scan", "holes", "method", "cuts", "sharp", "edges", "fans", "loops", "turned",
           "angles", "edge/rim", "seam", "fill s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("scans", type=Path, nargs="+")
    parser.add_argument("--pictures", type=Path, metavar="DIR")
    parser.add_argument("--most", type=int, default=6, help="holes of a scan that are pictured")
    parser.add_argument("--work", type=Path, help="where temporary files go")
    parser.add_argument("--timeout", type=float, default=300.0)
    options = parser.parse_args()
    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for scan in options.scans:
        with tempfile.TemporaryDirectory(dir=options.work) as folder:
            print(row(scan, options, Path(folder)), flush=True)


def row(scan, options, folder):
    ran = runs.convert(options.program.resolve(), scan, folder / "run", [], options.timeout)
    name = scan.name.split(".")[0]
    if not ran.filled:
        return f"| {name} | {ran.stderr[-1] if ran.stderr else ran.code} |" + " |" * (len(COLUMNS) - 2)
    mesh = meshes.read_filled(ran.filled)
    cuts, edges, topology = cutting(mesh), at_edges(mesh), meshes.topology(mesh)
    values = edges["values"]
    said = report(folder / "run" / "report.json")
    methods = Counter(h["method"] for h in said["holes"]) if said else {"?": 0}
    if options.pictures:
        draw(mesh, {"holes": holes(mesh, cuts, edges)}, options.pictures / name, options.most)
    cells = [
        name, str(len(np.unique(mesh.hole[mesh.fill]))),
        ", ".join(f"{n} {m}" for m, n in methods.items()),
        f"{cuts['fill'].sum()} / {cuts['measured'].sum()}",
        str(int((values["inside"] > 90).sum())),
        str(topology["nonmanifold_edges"]), str(topology["more_fans"]), str(topology["loops"]),
        str(topology["disagreeing_edges"]),
        " ".join(number(x, 0) for x in percentiles(meshes.min_angles(mesh, mesh.fill), [0, 1, 5, 50])),
        " ".join(number(x, 2) for x in percentiles(values["to_rim"], [5, 50, 95])),
        " ".join(number(x, 1) for x in percentiles(values["seam"], [50, 95])) + " ("
        + " ".join(number(x, 1) for x in percentiles(values["beside"], [50, 95])) + ")",
        number(ran.seconds.get("fill"), 2),
    ]
    return "| " + " | ".join(cells) + " |"


def holes(mesh, cuts, edges):
    """What the pictures are sorted by: the worst holes first."""
    of_face, of_edge = mesh.hole[mesh.fill], edges["hole"]["inside"]
    sharp = edges["values"]["inside"] > 90
    for hole in np.unique(of_face):
        mine = of_face == hole
        yield {"hole": int(hole), "folded": int((sharp & (of_edge == hole)).sum()),
               "cuts_fill": int(cuts["fill"][mine].sum()),
               "cuts_measured": int(cuts["measured"][mine].sum()),
               "area_max_mm": float(mesh.areas[mesh.fill][mine].sum())}


if __name__ == "__main__":
    main()
