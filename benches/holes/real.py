"""Fills the holes of real scans with scan2step, and measures the properties that need no
true surface: intersections, topology, angles, seams. It can make pictures.

    VENV/bin/python benches/holes/real.py target/release/scan2step SCAN... [--pictures DIR]
        [--most N] [--work DIR]

The columns are those of evaluate.py. 'folds' are edges inside the fill whose faces turn by
more than 107 degrees / the same at rims. 'crossed' are faults (folds and intersections) of
holes whose measured faces at the rim intersect or fold. No fill is free of faults there.
They are not included in the other columns.
"""

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import meshes
import run as runs
from evaluate import at_edges, cutting, number, percentiles, report
from intersections import cutting_pairs
from pictures import draw

FOLD = 107.46
COLUMNS = ["scan", "holes", "method", "cuts", "folds", "crossed", "edges", "fans", "loops", "turned",
           "angles", "edge/rim", "seam", "fill s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("scans", type=Path, nargs="+")
    parser.add_argument("--pictures", type=Path, metavar="DIR")
    parser.add_argument("--most", type=int, default=6, help="holes of a scan that are pictured")
    parser.add_argument("--work", type=Path, help="where temporary files go")
    parser.add_argument("--until-fill", action="store_true",
                        help="end there; the methods are not known then")
    parser.add_argument("--timeout", type=float, default=300.0)
    options = parser.parse_args()
    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for scan in options.scans:
        with tempfile.TemporaryDirectory(dir=options.work) as folder:
            print(row(scan, options, Path(folder)), flush=True)


def row(scan, options, folder):
    ran = runs.convert(options.program.resolve(), scan, folder / "run", [], options.timeout,
                       options.until_fill)
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
        *faults(mesh, cuts, edges),
        str(topology["nonmanifold_edges"]), str(topology["more_fans"]), str(topology["loops"]),
        str(topology["disagreeing_edges"]),
        " ".join(number(x, 0) for x in percentiles(meshes.min_angles(mesh, mesh.fill), [0, 1, 5, 50])),
        " ".join(number(x, 2) for x in percentiles(values["to_rim"], [5, 50, 95])),
        " ".join(number(x, 1) for x in percentiles(values["seam"], [50, 95])) + " ("
        + " ".join(number(x, 1) for x in percentiles(values["beside"], [50, 95])) + ")",
        number(ran.seconds.get("fill"), 2),
    ]
    return "| " + " | ".join(cells) + " |"


def faults(mesh, cuts, edges):
    """The intersections and folds of holes with valid rims, and the faults of the other
    holes."""
    crossed = np.array(sorted(crossed_rims(mesh, np.unique(mesh.hole[mesh.fill]))), int)
    count = lambda hole, bad: (int((bad & ~np.isin(hole, crossed)).sum()),
                               int((bad & np.isin(hole, crossed)).sum()))
    cut = [count(mesh.hole[mesh.fill], cuts[kind]) for kind in ("fill", "measured")]
    bent = [count(edges["hole"][kind], edges["values"][kind] > FOLD) for kind in ("inside", "seam")]
    both = lambda pair: f"{pair[0][0]} / {pair[1][0]}"
    return both(cut), both(bent), f"{sum(n for _, n in cut + bent)} of {len(crossed)} holes"


def crossed_rims(mesh, numbers):
    """The holes whose measured faces at the rim intersect or fold."""
    kind, sides = meshes.kinds(mesh), mesh.edges
    own = np.flatnonzero(kind == 0)
    folded = sides.ends[own[meshes.bends(mesh, own) > FOLD]]
    for hole in numbers:
        rim = np.unique(sides.ends[(kind == 1) & (mesh.hole[sides.faces].max(1) == hole)])
        near = mesh.measured[np.isin(mesh.triangles[mesh.measured], rim).any(1)]
        pairs = cutting_pairs(mesh.points, mesh.triangles, near) if len(near) else []
        cut = len(pairs) and (mesh.hole[pairs] < 0).all(1).any()
        if cut or np.isin(folded, rim).any():
            yield hole


def holes(mesh, cuts, edges):
    """The order of the pictures: the worst holes come first."""
    of_face, of_edge = mesh.hole[mesh.fill], edges["hole"]["inside"]
    sharp = edges["values"]["inside"] > FOLD
    for hole in np.unique(of_face):
        mine = of_face == hole
        yield {"hole": int(hole), "folded": int((sharp & (of_edge == hole)).sum()),
               "cuts_fill": int(cuts["fill"][mine].sum()),
               "cuts_measured": int(cuts["measured"][mine].sum()),
               "area_max_mm": float(mesh.areas[mesh.fill][mine].sum())}


if __name__ == "__main__":
    main()
