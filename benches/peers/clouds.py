"""Compares triangles from clouds of points with CGAL, Open3D and MeshLab, and with the truth.

    VENV/bin/python benches/peers/clouds.py [--scans relief60k,relief250k] [--peers ours,cgal-chain ...]

`run.py` explains how to make VENV. CGAL's chain needs g++ and the Debian packages libcgal-dev and
libeigen3-dev. The script needs Linux. It prints a Markdown table for clouds with a known true
surface, an outer loop and three holes:

- plain: the points of a virtual scan in any order.
- layers: two other scans of the same surface are added, and each of the three is moved by half of
  the noise.
- outliers: one point in a hundred is moved, half of these far away, half by 2 to 20 times the noise.
- density: the density falls from one side to the other to a fifth.

Every program runs in its own process. CPU seconds are those of all threads for the work alone, MB
is the peak of the process. "Loops" counts the true loops found, of four, and the false ones. The rms is
the distance of the vertices from the true surface as a multiple of the noise. "Area" is the area
seen from above, where folds count as negative, as a share of the true one. A cloud is "right" if
the mesh is manifold, oriented and one piece, with all true loops and no false one, and with the
area within 3 %.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parent)]
import made
from clouds_check import check

NOISE_MM = 0.08
VARIANTS = ["plain", "layers", "outliers", "density"]
# Scans of the same surface with other points and other noise.
LAYERS = {"relief60k": ["relief10k", "relief100k"], "relief250k": ["relief60k", "relief100k"]}
PEERS = ["ours", "cgal-front", "cgal-chain", "open3d-balls", "open3d-poisson", "meshlab-balls",
         "meshlab-poisson"]
COLUMNS = ["cloud", "points", "program", "right", "manifold", "oriented", "pieces", "loops",
           "false loops", "rms / noise", "area", "CPU s", "MB"]
# Ball pivoting takes more than this for 250,000 points with some programs.
TIMEOUT_S = 300


def main(given=None):
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("--scans", default="relief60k,relief250k")
    parser.add_argument("--variants", default=",".join(VARIANTS))
    parser.add_argument("--peers", default=",".join(PEERS))
    options = parser.parse_args(given)
    row(COLUMNS)
    row(["---"] * len(COLUMNS))
    with tempfile.TemporaryDirectory() as folder:
        for scan in options.scans.split(","):
            for variant in options.variants.split(","):
                beside(scan, variant, options.peers.split(","), Path(folder))


def beside(scan, variant, peers, folder):
    cloud, area = made_cloud(scan, variant), true_area(scan)
    spacing = measured_spacing(cloud)
    raw, ply = folder / "points", folder / "points.ply"
    cloud.tofile(raw)
    write_ply(ply, cloud)
    for peer in peers:
        cells = [f"{scan} {variant}", f"{len(cloud):,}", peer]
        try:
            told, mesh = run(peer, raw, ply, spacing, folder)
        except subprocess.TimeoutExpired:
            row(cells + [f"stopped after {TIMEOUT_S} s"] + [""] * 9)
            continue
        except (subprocess.CalledProcessError, FileNotFoundError) as error:
            said = str(getattr(error, "stderr", None) or error).strip().splitlines()[-1][-80:]
            row(cells + [f"failed: {said}"] + [""] * 9)
            continue
        found = check(*mesh)
        rms = made.rms(scan, found.used) / NOISE_MM
        share = found.area / area
        right = (found.manifold and found.oriented and found.pieces == 1 and found.true_loops == 4
                 and found.false_loops == 0 and abs(share - 1) < 0.03)
        row(cells + [yes(right), yes(found.manifold), yes(found.oriented), found.pieces,
                     f"{found.true_loops} of 4", found.false_loops, f"{rms:.2f}", f"{share:.3f}",
                     f"{told['cpu_s']:.2f}", f"{told['peak_rss_mb']:.0f}"])


def run(peer, raw, ply, spacing, folder):
    """What the program says, and its mesh."""
    import numpy as np

    out = folder / ("out.npz" if peer.startswith(("open3d", "meshlab")) else "out.ply")
    out.unlink(missing_ok=True)
    if peer == "ours":
        command = [made.built("measure"), ply, "--cloud", out]
    elif peer.startswith("cgal"):
        command = [cgal(), raw, repr(spacing), out, peer.removeprefix("cgal-")]
    else:
        command = [sys.executable, "-B", HERE / "clouds_peers.py", peer, raw, repr(spacing), out]
    ended = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True,
                           timeout=TIMEOUT_S)
    told = json.loads(ended.stdout.splitlines()[-1])
    if peer == "ours":
        told["cpu_s"] = told["cpu_s"]["cloud"]
    if out.suffix == ".ply":
        return told, made.read_ply(out)
    mesh = np.load(out)
    return told, (mesh["points"], mesh["triangles"].astype(np.int64))


@cache
def cgal():
    """The program with CGAL's functions, built once."""
    folder = made.ROOT / "target" / "peers"
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "clouds_cgal"
    source = HERE / "clouds_cgal.cpp"
    flags = ["-O3", "-DNDEBUG", "-std=c++17", "-I/usr/include/eigen3", "-DCGAL_EIGEN3_ENABLED"]
    command = ["g++", *flags, source, "-lgmp", "-lmpfr", "-o", program]
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True)
    return program


def made_cloud(scan, variant):
    """The points of a variant in random order."""
    import numpy as np

    random = np.random.default_rng(7)
    uv, points = made.samples(scan)
    if variant == "density":
        stays = random.random(len(points)) < 1 - 0.8 * uv[:, 0]
        uv, points = uv[stays], points[stays]
    if variant == "layers":
        layers = [points, *(made.samples(name)[1] for name in LAYERS[scan])]
        steps = random.normal(size=(3, 3))
        steps *= 0.5 * NOISE_MM / np.linalg.norm(steps, axis=1)[:, None]
        points = np.concatenate([layer + step for layer, step in zip(layers, steps)])
    if variant == "outliers":
        moved = random.choice(len(points), len(points) // 100, replace=False)
        far, near = np.array_split(moved, 2)
        low, high = points.min(axis=0), points.max(axis=0)
        points[far] = random.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (len(far), 3))
        sides = random.choice([-1, 1], len(near))
        points[near, 2] += sides * NOISE_MM * random.uniform(2, 20, len(near))
    return np.ascontiguousarray(points[random.permutation(len(points))])


@cache
def true_area(scan):
    """The area seen from above of the mesh that the scan has."""
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        path = made.scan(scan, Path(folder) / "scan.ply")
        head, body = path.read_bytes().split(b"end_header\n", 1)
        kind = "<f8" if b"property double x" in head else "<f4"
        counts = [int(line.split()[2]) for line in head.splitlines() if line.startswith(b"element")]
        points = np.frombuffer(body, kind, 3 * counts[0]).reshape(-1, 3)
        rows = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], counts[1], points.nbytes)
    a, b, c = (points[rows["v"][:, i], :2].astype(float) for i in range(3))
    return abs(flat_area(a, b, c))


def flat_area(a, b, c):
    (p, q), (r, s) = (b - a).T, (c - a).T
    return float((p * s - q * r).sum() / 2)


def measured_spacing(points):
    """The median of the spacing that the distance of the eighth neighbour tells."""
    import numpy as np
    from scipy.spatial import cKDTree

    eighth = cKDTree(points).query(points, [9])[0]
    return float(np.median(eighth) * np.sqrt(np.pi / 8))


def write_ply(path, points):
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
              "property double x\nproperty double y\nproperty double z\nend_header\n")
    path.write_bytes(header.encode() + points.astype("<f8").tobytes())


def yes(answer):
    return "yes" if answer else "no"


def row(cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
