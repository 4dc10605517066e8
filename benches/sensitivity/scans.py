"""The scans that are converted again and again: virtual ones, fixtures, and real ones if they are
present. All are small, so that a conversion takes about a second.
"""

import gzip
import sys
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import made


@dataclass
class Scan:
    name: str
    path: Path
    options: list = field(default_factory=list)


# A real scan, for a cut its middle vertex and its number of vertices, and the options. The cuts have
# ragged rims with holes, and some have several components.
REAL = [
    ("roof_inspired.obj", None, ["--tolerance", "0.1"]),
    ("tower_lilium.obj.gz", None, []),
    ("stl_wavy_sheet.stl.gz", None, ["--keep-fills"]),
    ("face_mannequin_small.ply", None, []),
    ("lucy_partial.obj.gz", (9000, 400), ["--component", "all"]),
    ("rangescan_hippo1.obj.gz", (15000, 1200), []),
    ("bun_chin_patch.obj.gz", (18000, 600), []),
    ("dragon096_patch.obj.gz", (8000, 1200), ["--outline", "trimmed"]),
    ("head_scan_flame.obj.gz", (20000, 1200), ["--tolerance", "1"]),
    ("face_maxplanck_partial.obj.gz", (9000, 1200), ["--fit", "blend", "--map", "mean-value"]),
    ("bunny_flank.obj.gz", (3000, 900), ["--units", "m", "--outline", "sides"]),
    ("lion_head.obj.gz", (3000, 900), ["--units", "m", "--smooth", "off"]),
]


def all_scans(folder, shared):
    """Writes the scans to a folder and returns them."""
    folder.mkdir(parents=True, exist_ok=True)
    return [*virtual(folder), *real(folder, shared)]


def virtual(folder):
    """Scans that anyone can make."""
    paper = folder / "paper2500.ply"
    if not paper.exists():
        made.scan("paper2500", paper)
    fixtures = made.ROOT / "fixtures"
    return [
        Scan("paper2500", paper, ["--tolerance", "0.1"]),
        Scan("relief", fixtures / "relief.ply"),
        Scan("cloud", fixtures / "relief.xyz"),
        Scan("ring", fixtures / "ring.obj"),
        Scan("rolled_sheet", fixtures / "rolled_sheet.obj", ["--fit", "global", "--keep-fills"]),
    ]


def real(folder, shared):
    if not shared.is_dir():
        print(f"There are no real scans in {shared}. Only virtual scans are measured.")
        return []
    scans = []
    for file, cut_out, options in REAL:
        name, path = file.split(".")[0], shared / file
        if cut_out:
            path = cut(path, *cut_out, folder / f"{name}.obj")
        scans.append(Scan(name, path, options))
    return scans


def cut(source, middle, count, path):
    """Writes the triangles between the `count` vertices of an OBJ file nearest to vertex `middle`."""
    with gzip.open(source, "rt") as file:
        rows = [line.split() for line in file]
    points = [[float(x) for x in row[1:4]] for row in rows if row and row[0] == "v"]
    faces = [[int(v.split("/")[0]) - 1 for v in row[1:]] for row in rows if row and row[0] == "f"]
    centre = points[middle]
    distance = lambda v: sum((a - b) ** 2 for a, b in zip(points[v], centre))
    kept = sorted(sorted(range(len(points)), key=distance)[:count])
    number = {v: n + 1 for n, v in enumerate(kept)}
    lines = ["v {} {} {}\n".format(*points[v]) for v in kept]
    lines += ["f {} {} {}\n".format(*map(number.get, f)) for f in faces if number.keys() >= set(f)]
    path.write_text("".join(lines))
    return path
