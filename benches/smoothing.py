"""Compares smoothing with the truth of virtual scans.

    python3 -m venv VENV
    VENV/bin/pip install numpy scipy
    VENV/bin/python benches/smoothing.py [SCAN[:NOISE[:SEED]] ...]

The script prints a Markdown table: the root mean square distances from the true surface over all
vertices, before and after; that of the smoothed outer boundary from the true boundary curve; how far
vertices were moved; the triangles whose normals are opposite to the true ones, before and after; the
CPU seconds of all threads for a million points; and the peak memory of the process.

virtual_scan.py makes the scans. It is not part of the project. If it is not in ../shared beside the
checkout, the script measures nothing and says so.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import made

SHARED = made.ROOT.parent / "shared"
SCANS = ["paper8100", "roll40k", "relief60k", "relief250k", "relief1m",
         "paper8100:0", "roll40k:0", "relief250k:0"]
TITLES = ["scan", "noise", "rms before", "rms", "outer", "moved rms",
          "folded before", "folded", "h", "noise found", "CPU s/M", "peak MB"]


def main():
    if not (SHARED / "virtual_scan.py").exists():
        sys.exit(f"NOT MEASURED: {SHARED / 'virtual_scan.py'} is absent; it is not part of the project")
    sys.path.insert(0, str(SHARED))
    program = made.built("measure")
    print("| " + " | ".join(TITLES) + " |\n|" + " --- |" * len(TITLES))
    for scan in sys.argv[1:] or SCANS:
        name, noise, seed = (scan.split(":") + ["", ""])[:3]
        row = measure(program, name, float(noise) if noise else None, int(seed or 0))
        print("| " + " | ".join(row) + " |", flush=True)


def measure(program, name, noise, seed):
    import numpy as np
    import virtual_scan as vs

    points, triangles, _ = vs.scan(name, seed, noise)
    with tempfile.TemporaryDirectory() as folder:
        scan, out = Path(folder) / "scan.ply", Path(folder) / "out.ply"
        vs.write_ply(scan, points, triangles)
        run = subprocess.run([program, scan, "--smooth", out], check=True, stdout=subprocess.PIPE)
        found = json.loads(run.stdout)
        smooth, faces = made.read_ply(out)
        outer = max(json.loads(out.with_suffix(".loops.json").read_text()), key=len)
    rms = lambda x: np.sqrt(np.mean(np.square(x)))
    curve = true_boundary(vs.SCANS[name][0])
    distance = lambda p: rms(vs.truth_distance(name, p))
    return [
        name,
        f"{vs.SCANS[name][3] if noise is None else noise:g}",
        f"{distance(points):.4f}",
        f"{distance(smooth):.4f}",
        f"{rms(curve.query(smooth[outer])[0]):.4f}",
        f"{found['moved_rms_mm']:.4f}",
        str(folded(name, points, triangles)),
        str(folded(name, smooth, faces)),
        f"{found['h_mm']:.2f}",
        f"{found['noise_mm']:.4f}",
        f"{found['cpu_s']['smooth'] / found['vertices'] * 1e6:.1f}",
        f"{found['peak_rss_mb']:.0f}",
    ]


def true_boundary(truth):
    import numpy as np
    from scipy.spatial import cKDTree

    t, zero = np.linspace(0, 1, 40001), np.zeros(40001)
    sides = [(t, zero), (t, zero + 1), (zero, t), (zero + 1, t)]
    return cKDTree(np.concatenate([truth(u, v) for u, v in sides]))


def folded(name, points, triangles):
    """The triangles whose normals are opposite to that of the true surface nearby."""
    import numpy as np
    import virtual_scan as vs
    from scipy.spatial import cKDTree

    truth, n, e = vs.SCANS[name][0], 1200, 1e-5
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    _, near = cKDTree(truth(u, v).reshape(-1, 3)).query(points[triangles].mean(1), workers=-1)
    u, v = u.ravel()[near], v.ravel()[near]
    normal = np.cross(truth(u + e, v) - truth(u - e, v), truth(u, v + e) - truth(u, v - e))
    a, b, c = (points[triangles[:, k]] for k in range(3))
    side = (np.cross(b - a, c - a) * normal).sum(1)
    return int(min((side <= 0).sum(), (side >= 0).sum()))


if __name__ == "__main__":
    main()
