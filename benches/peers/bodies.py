"""Compares the solids of bodies with what else leads from a closed mesh to CAD.

    VENV/bin/python benches/peers/bodies.py SCAN.obj ...

`run.py` explains how to make VENV. The script prints a Markdown table with a line for each program:
CPU seconds of all threads, faces, size of the STEP file, seconds in which OpenCASCADE (through
FreeCAD) reads it, whether the shape is valid, and the root mean square distance of the scan's
vertices from the surface. QuadriFlow and Instant Meshes make quads, as many as scan2step's layout
has. Their surface is the Catmull-Clark surface of these quads. No open program writes it as STEP, so
that there is no file. FreeCAD's Shape from mesh makes a plane face of each triangle.
"""

import gzip
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent))
import made

COLUMNS = ["scan", "program", "CPU s", "faces", "STEP MB", "opens in s", "valid", "rms mm"]

# Quads of a block of scan2step's layout.
QUADS = 64
# Shape from mesh is stopped after so many seconds.
PATIENCE = 600
# Distances are measured at so many of the scan's vertices.
VERTICES = 4000


def main(scans):
    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for scan in map(Path, scans):
        with tempfile.TemporaryDirectory() as folder:
            beside(scan, Path(folder))


def beside(scan, folder):
    mesh = read(scan, folder)
    step, report = folder / "own.step", folder / "own.json"
    own = [made.built("scan2step", "bin"), "convert", scan, step, "--report", report, "--quiet", "--threads", "1"]
    seconds = cpu(lambda: subprocess.run(own, check=True))
    told = json.loads(report.read_text())
    faces = told["shape"]["faces"]
    line(scan, "scan2step", seconds, faces, step, told["deviation"]["rms_mm"])
    for name, remesh in [("QuadriFlow", quadriflow), ("Instant Meshes", instant_meshes)]:
        found, seconds = child(remesh, mesh, faces * QUADS)
        off = rms(mesh, *found) if found else None
        line(scan, name, seconds, len(found[1]) if found else None, None, off)
    step = folder / "planes.step"
    script = [
        "import Mesh, Part",
        f"mesh = Mesh.Mesh({str(folder / 'mesh.stl')!r})",
        "shape = Part.Shape()",
        "shape.makeShapeFromMesh(mesh.Topology, 0.0)",
        f"Part.Solid(Part.Shell(shape.Faces)).exportStep({str(step)!r})",
    ]
    seconds = cpu(lambda: freecad("\n".join(script)))
    line(scan, "FreeCAD: Shape from mesh", seconds, len(mesh.faces), step if step.exists() else None, 0.0)


def read(scan, folder):
    import trimesh

    opened = gzip.open if scan.suffix == ".gz" else open
    with opened(scan, "rb") as file:
        mesh = trimesh.load(file, file_type=scan.name.split(".")[1], force="mesh")
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.export(folder / "mesh.stl")
    return mesh


def cpu(run):
    """The CPU seconds of the processes that a call starts."""
    times = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = times()
    run()
    return times() - before


def child(work, *arguments):
    """The result of work in a process of its own, and its CPU seconds; no result if it ends early."""
    import pickle

    with tempfile.TemporaryFile() as file:
        def run():
            pid = os.fork()
            if pid == 0:
                try:
                    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                    pickle.dump(work(*arguments), file)
                    file.flush()
                finally:
                    os._exit(0)
            os.waitpid(pid, 0)
        seconds = cpu(run)
        file.seek(0)
        data = file.read()
    return (pickle.loads(data) if data else None), seconds


def quadriflow(mesh, count):
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow
    import numpy as np

    made = pyquadriflow(count, 0, mesh.vertices.tolist(), mesh.faces.tolist(), *5 * [False])
    return np.array(made["vertices"]), np.array(made["faces"])


def instant_meshes(mesh, count):
    import pyinstantmeshes
    import numpy as np

    # It divides each face in four to get quads only, and returns two triangles for each quad.
    points, faces = pyinstantmeshes.remesh(
        mesh.vertices, mesh.faces, target_face_count=count // 4, pure_quad=True, deterministic=True
    )
    return np.array(points, float), np.hstack([faces[::2], faces[1::2, :1]])


def rms(mesh, points, quads):
    """The distance of vertices of the scan from the Catmull-Clark surface of quads."""
    import numpy as np
    import trimesh

    for _ in range(3):
        points, quads = subdivided(points, quads)
    triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    surface = trimesh.Trimesh(points, triangles, process=False)
    chosen = np.random.default_rng(0).permutation(len(mesh.vertices))[:VERTICES]
    _, distances, _ = trimesh.proximity.closest_point(surface, mesh.vertices[chosen])
    return float(np.sqrt(np.mean(distances**2)))


def subdivided(points, quads):
    """One step of Catmull and Clark, "Recursively generated B-spline surfaces" (1978)."""
    import numpy as np

    middles = points[quads].mean(axis=1)
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, of_side = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    of_side = of_side.reshape(-1)
    beside = np.zeros((len(edges), 3))
    uses = np.bincount(of_side, minlength=len(edges))
    np.add.at(beside, of_side, np.repeat(middles, 4, axis=0))
    ends = points[edges].sum(axis=1)
    on_edges = np.where((uses == 2)[:, None], (ends + beside) / 4, ends / 2)
    valence = np.bincount(quads.ravel(), minlength=len(points))
    around, along = np.zeros_like(points), np.zeros_like(points)
    np.add.at(around, quads.ravel(), np.repeat(middles, 4, axis=0))
    for k in (0, 1):
        np.add.at(along, edges[:, k], ends / 2)
    n = np.maximum(valence, 1)[:, None]
    moved = (around / n + 2 * along / n + (n - 3) * points) / n
    first_middle, first_edge = len(points), len(points) + len(quads)
    side = of_side.reshape(-1, 4) + first_edge
    middle = np.arange(len(quads)) + first_middle
    finer = [np.stack([quads[:, k], side[:, k], middle, side[:, k - 1]], axis=1) for k in range(4)]
    return np.vstack([moved, middles, on_edges]), np.vstack(finer)


def freecad(script):
    with tempfile.NamedTemporaryFile("w", suffix=".py") as file:
        file.write(script + "\n")
        file.flush()
        try:
            run = subprocess.run(["freecadcmd", file.name], capture_output=True, text=True, timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return ""
    return run.stdout


def opened(step):
    """The seconds in which a STEP file is read, and whether its shape is a valid solid."""
    begin = time.monotonic()
    said = freecad(f"import Part, time\nt = time.time()\ns = Part.read({str(step)!r})\n"
                   "print('read', time.time() - t, len(s.Solids) > 0 and s.isValid())")
    for words in (text.split() for text in said.splitlines() if text.startswith("read ")):
        return float(words[1]), words[2]
    return time.monotonic() - begin, "not in time"


def line(scan, program, seconds, faces, step, off):
    size = f"{step.stat().st_size / 1e6:.2f}" if step else "–"
    opens, valid = opened(step) if step else (None, "–")
    cells = [scan.name.split(".")[0], program, f"{seconds:.1f}", faces or "none", size]
    cells += ["–" if opens is None else f"{opens:.2f}", valid, "–" if off is None else f"{off:.4g}"]
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or sys.exit(__doc__))
