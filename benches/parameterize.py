#!/usr/bin/env python3
"""Measures the maps of scan2step to the square: inverted triangles, L2 stretch, and the
error of a fit with a uniform 26 x 26 net at the parameters.

    python3 -B benches/parameterize.py PROGRAM [--shared FOLDER]

The script needs numpy and scipy. It omits the virtual scans and says so if the folder with
virtual_scan.py is missing.
"""
import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.sparse.linalg import splu


def grid(n, m, surface, seed=0):
    """A grid of n x m points with random diagonals."""
    u, v = (t.ravel() for t in np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, m), indexing="ij"))
    i = np.arange(n * m).reshape(n, m)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    flip = (np.random.default_rng(seed).random(a.size) < 0.5)[:, None]
    first = np.where(flip, np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    second = np.where(flip, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return surface(u, v), np.concatenate([first, second])


def nose(u, v):
    x, y = 100 * (u - 0.5), 100 * (v - 0.5)
    return np.stack([x, y, 70 * np.exp(-(x * x + y * y) / 90)], 1)


def disk(u, v):
    """Maps the square to a disk of radius 1, ring by ring."""
    a, b = 2 * u - 1, 2 * v - 1
    k = np.maximum(abs(a), abs(b)) / np.maximum(np.hypot(a, b), 1e-12)
    return a * k, b * k


def sphere(angle):
    """The part of a sphere within an angle from its pole."""
    def surface(u, v):
        x, y = disk(u, v)
        r = np.maximum(np.hypot(x, y), 1e-12)
        t = r * angle
        return 50 * np.stack([x / r * np.sin(t), y / r * np.sin(t), np.cos(t)], 1)
    return surface


def bowl(depth):
    """A bowl with a flat bottom and steep walls."""
    def surface(u, v):
        x, y = disk(u, v)
        return 50 * np.stack([x, y, depth * np.hypot(x, y) ** 6], 1)
    return surface


def finger(length):
    """A round finger with a thickness of 10 mm on a disk."""
    def surface(u, v):
        x, y = disk(u, v)
        r = np.maximum(np.hypot(x, y), 1e-12)
        radius = np.where(r < 0.1, 50 * r, np.where(r < 0.8, 5, 5 + 225 * (r - 0.8)))
        height = length * np.clip((0.8 - r) / 0.7, 0, 1)
        return np.stack([x / r * radius, y / r * radius, height], 1)
    return surface


def strip(u, v):
    return np.stack([100 * u, 5 * v, np.sin(10 * u)], 1)


CASES = {
    "nose": (141, 141, nose),
    "hemisphere": (141, 141, sphere(np.pi / 2)),
    "cap of 126 degrees": (141, 141, sphere(2.2)),
    "sphere but for a pole": (401, 401, sphere(3.12)),
    "bowl": (141, 141, bowl(2.5)),
    "finger 10:1": (201, 201, finger(100)),
    "strip 20:1": (401, 21, strip),
}
VIRTUAL = ["paper8100", "roll40k", "relief250k", "relief1m"]


def write_ply(path, points, triangles):
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(triangles), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, triangles
    path.write_bytes(header.encode() + points.astype("<f8").tobytes() + rows.tobytes())


def read_stage(path):
    """The points, the parameters and the measured triangles."""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in data[:start].decode().splitlines() if line.startswith("element")]
    vertex = [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("origin", "u1"), ("u", "<f8"), ("v", "<f8")]
    face = [("n", "u1"), ("v", "<i4", 3), ("hole", "<i4")]
    vertices = np.frombuffer(data, vertex, counts[0], start)
    faces = np.frombuffer(data, face, counts[1], start + vertices.nbytes)
    points = np.stack([vertices[k] for k in "xyz"], 1)
    uv = np.stack([vertices[k] for k in "uv"], 1)
    return points, uv, faces["v"], faces["hole"] < 0


def stretch(points, uv, triangles):
    """The L2 stretch on the rectangle of least stretch, and the number of inverted triangles."""
    p, q, r = (points[triangles[:, k]] for k in range(3))
    a, d, e = uv[triangles[:, 0]], uv[triangles[:, 1]], uv[triangles[:, 2]]
    d, e = d - a, e - a
    twice = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1)
    su = ((q - p) * e[:, 1:] - (r - p) * d[:, 1:]) / twice[:, None]
    sv = ((r - p) * d[:, :1] - (q - p) * e[:, :1]) / twice[:, None]
    along = [(area * (s**2).sum(1)).sum() for s in (su, sv)]
    return np.sqrt(0.5 * twice.sum() * np.sqrt(along[0] * along[1])) / area.sum(), int((twice <= 0).sum())


def fit_rms(points, uv, n=26):
    """The error of a uniform least-squares fit at the same parameters."""
    knots = np.r_[[0.0] * 3, np.linspace(0, 1, n - 2), [1.0] * 3]
    u, v = (BSpline.design_matrix(uv[:, k], knots, 3) for k in range(2))
    (iu, iv), (du, dv) = ([b.indices.reshape(-1, 4) for b in (u, v)], [b.data.reshape(-1, 4) for b in (u, v)])
    columns = (iu[:, :, None] * n + iv[:, None, :]).reshape(-1)
    values = (du[:, :, None] * dv[:, None, :]).reshape(-1)
    matrix = sparse.csr_matrix((values, columns, 16 * np.arange(len(uv) + 1)), (len(uv), n * n))
    net = splu((matrix.T @ matrix + 1e-9 * sparse.identity(n * n)).tocsc()).solve(matrix.T @ points)
    return np.sqrt(((matrix @ net - points) ** 2).sum(1).mean())


def run(program, name, scan, folder, *options):
    stages, report = folder / "stages", folder / "report.json"
    command = [program, "convert", scan, folder / "out.step", "--quiet", "--net", "26x26",
               "--stages", stages, "--report", report, *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    points, uv, triangles, measured = read_stage(stages / "4-parameterized.ply")
    l2, _ = stretch(points, uv, triangles[measured])
    _, flips = stretch(points, uv, triangles)
    said = json.loads(report.read_text())
    took = next(s["seconds"] for s in said["stages"] if s["name"] == "parameterize")
    most = said["parameterize"]["stretch_max"]
    print(f"| {name} | {flips} | {l2:.4f} | {most:.2f} | {fit_rms(points, uv):.4f} | {took:.2f} | {whole:.1f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--shared", type=Path, default=Path(__file__).resolve().parents[2] / "shared")
    options = parser.parse_args()
    print("| case | flips | L2 stretch | largest | rms of the 26 × 26 fit, mm | wall s | CPU s of the whole run |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        scan = folder / "scan.ply"
        for name, (n, m, surface) in CASES.items():
            write_ply(scan, *grid(n, m, surface))
            run(options.program, name, scan, folder, "--smooth", "off")
        if not (options.shared / "virtual_scan.py").exists():
            sys.exit("virtual_scan.py is absent: no virtual scans")
        sys.path.insert(0, str(options.shared))
        import virtual_scan

        for name in VIRTUAL:
            points, triangles, _ = virtual_scan.scan(name)
            write_ply(scan, points, triangles)
            run(options.program, name, scan, folder)


if __name__ == "__main__":
    main()
