"""Compares reading clouds of points with laspy, pye57, Open3D and pypcd4.

    VENV/bin/python benches/peers/points.py [--folder FOLDER] [--runs N] [--ours PROGRAM]

`run.py` explains how to make VENV. It also needs laspy[lazrs], pye57 and pypcd4. The script prints
a Markdown table. It writes a cloud of a million points in each format to FOLDER (default:
target/peers) the first time. PROGRAM is a built formats/examples/points. The script needs Linux.

Every task runs N times (default: 3) in its own process, and each figure is the smallest of its
runs. CPU seconds are the user and system time of all threads without those of a process that only
imports the tool. MB are 10^6 bytes of peak resident memory, imports included. The sum of
the bits of all coordinates shows whether both programs read the same points.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parent)]
import made
from read import least, measure, row
from read_peers import peak_rss_mb

COUNT = 1_000_000
PEERS = {
    "e57": "pye57",
    "las": "laspy",
    "laz": "laspy",
    "ply": "open3d",
    "xyz": "open3d",
    "pcd": "pypcd4",
}


def main():
    if sys.argv[1:2] == ["peer"]:
        print(json.dumps(read_with(*sys.argv[2:]) | {"peak_rss_mb": peak_rss_mb()}))
        return
    options = arguments()
    write(options.folder)
    ours = options.ours or built()
    row(["format", "tool", "CPU s", "wall s", "peak MB", "points", "sum of bits"])
    row(["---"] * 2 + ["--:"] * 5)
    for ending, peer in PEERS.items():
        file = options.folder / f"cloud.{ending}"
        itself = [sys.executable, __file__, "peer", peer]
        base = best(options.runs, itself)
        tell(ending, "scan2step", best(options.runs, [ours, file]), None)
        tell(ending, peer, best(options.runs, [*itself, file]), base)


def arguments():
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("--folder", type=Path, default=made.ROOT / "target" / "peers")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--ours", type=Path)
    return parser.parse_args()


def built():
    cargo = ["cargo", "build", "--release", "-p", "scan2step-formats", "--example", "points"]
    subprocess.run(cargo, cwd=made.ROOT, check=True)
    return made.ROOT / "target" / "release" / "examples" / "points"


def best(runs, command):
    found = measure(command)
    for _ in range(runs - 1):
        found = least(found, measure(command))
    return found


def tell(ending, tool, found, base):
    cpu, wall = (found[k] - (base[k] if base else 0) for k in ["cpu_s", "wall_s"])
    memory = f"{found['peak_rss_mb']:.0f}"
    row([ending, tool, f"{cpu:.2f}", f"{wall:.2f}", memory, found["points"], found["sum"]])


def cloud():
    """Points of a relief as a survey has them: far from zero, in whole millimetres."""
    import numpy as np

    random = np.random.default_rng(1)
    x, y = random.uniform(0, 100, (2, COUNT))
    z = 100 + 5 * np.sin(x / 7) * np.cos(y / 9) + random.normal(0, 0.005, COUNT)
    return np.round(np.stack([400_000 + x, 5_800_000 + y, z], 1), 3)


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    missing = [ending for ending in PEERS if not (folder / f"cloud.{ending}").exists()]
    points = cloud() if missing else None
    for ending in missing:
        globals()[f"write_{ending}"](folder / f"cloud.{ending}", points)


def write_las(path, points):
    import laspy

    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [0.001] * 3, [400_000, 5_800_000, 0]
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.write(path)


write_laz = write_las


def write_e57(path, points):
    import pye57

    with pye57.E57(str(path), mode="w") as file:
        axes = ["cartesianX", "cartesianY", "cartesianZ"]
        file.write_scan_raw(dict(zip(axes, points.T.copy())))


def write_ply(path, points):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {COUNT}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(head.encode() + points.astype("<f8").tobytes())


def write_xyz(path, points):
    with path.open("w") as file:
        for some in points.reshape(-1, 10_000, 3):
            file.write("%.3f %.3f %.3f\n" * len(some) % tuple(some.ravel().tolist()))


def write_pcd(path, points):
    head = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\n"
    head += f"TYPE F F F\nCOUNT 1 1 1\nWIDTH {COUNT}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
    head += f"POINTS {COUNT}\nDATA binary\n"
    path.write_bytes(head.encode() + points.astype("<f8").tobytes())


def read_with(tool, path=None):
    import numpy as np

    if tool == "laspy":
        import laspy

        read = lambda: (lambda las: [las.x, las.y, las.z])(laspy.read(path))
    elif tool == "pye57":
        import pye57

        def read():
            scan = pye57.E57(path).read_scan_raw(0)
            return [scan[f"cartesian{axis}"] for axis in "XYZ"]
    elif tool == "open3d":
        import open3d

        read = lambda: np.asarray(open3d.io.read_point_cloud(path).points).T
    else:
        import pypcd4

        read = lambda: pypcd4.PointCloud.from_path(path).numpy(("x", "y", "z")).T
    if path is None:
        return {"points": 0, "sum": 0}
    axes = [np.asarray(axis) for axis in read()]
    bits = np.concatenate([axis.astype("<f8") for axis in axes]).view("<u8")
    return {"points": len(axes[0]), "sum": int(bits.sum(dtype="<u8"))}


if __name__ == "__main__":
    main()
