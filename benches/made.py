"""The inputs of benches: built programs, and virtual scans with known true surfaces from
examples/virtual_scan.
"""

import json
import subprocess
import tempfile
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@cache
def built(name, kind="example"):
    """The path of an example, or of a program with kind 'bin'."""
    cargo = ["cargo", "build", "--release", f"--{kind}", name, "--message-format", "json"]
    lines = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout.splitlines()
    targets = [b for b in map(json.loads, lines) if b.get("target", {}).get("name") == name]
    return [b["executable"] for b in targets if b.get("executable")][-1]


def virtual_scan(name, *task):
    command = [built("virtual_scan"), name, *task]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def scan(name, path):
    """Writes a scan as a PLY file."""
    virtual_scan(name, path)
    return path


def samples(name):
    """The true parameters of a scan's points, and the points."""
    table = numbers(name, "samples", 5)
    return table[:, :2].copy(), table[:, 2:].copy()


def places(name):
    """Parameter points all over the surface, and whether each is in a hole."""
    table = numbers(name, "places", 3)
    return table[:, :2].copy(), table[:, 2] > 0


def numbers(name, task, columns):
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        virtual_scan(name, task, Path(folder) / "out")
        return np.fromfile(Path(folder) / "out").reshape(-1, columns)


def rms(name, points):
    """The root mean square distance of points from the true surface, in mm."""
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        np.ascontiguousarray(points, "<f8").tofile(Path(folder) / "points")
        return float(virtual_scan(name, "rms", Path(folder) / "points"))


def read_ply(path):
    """The points and triangles of a mesh that examples/measure wrote."""
    import numpy as np

    head, body = path.read_bytes().split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.splitlines() if line.startswith(b"element")]
    points = np.frombuffer(body, "<f8", 3 * counts[0]).reshape(-1, 3)
    rows = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], counts[1], 24 * counts[0])
    return points, rows["v"].astype(np.int64)
