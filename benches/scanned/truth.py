"""Labels the vertices of scans with the true faces of the CAD parts that they were made from.

  python truth.py PARTS CACHE [name ...]

PARTS holds judge.py, truth/NAME.json, step/NAME.step.gz and scan/NAME.ply.gz. For each part CACHE/NAME.npz gets the points of the
scan, the true face of each vertex, and of each face its kind, its width, its area and its parameters in the coordinates of the scan.
Needs OpenCASCADE's Python.
"""

import gzip
import json
import pathlib
import sys

import numpy as np


def points_of(path):
    """The points of a binary little-endian or ASCII PLY file whose vertices begin with x, y, z."""
    data = gzip.open(path).read() if path.suffix == ".gz" else path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    types = {"float": "<f4", "double": "<f8", "float32": "<f4", "float64": "<f8", "uchar": "u1", "int": "<i4", "short": "<i2"}
    fields, count, inside = [], 0, False
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count, inside = int(words[2]), True
        elif words[:1] == ["element"]:
            inside = False
        elif words[:1] == ["property"] and inside:
            fields.append((words[2], types[words[1]]))
    if b"format ascii" in head:
        return np.loadtxt(body.decode().splitlines()[:count], usecols=(0, 1, 2))
    table = np.frombuffer(body, dtype=fields, count=count)
    return np.stack([table[k].astype(float) for k in "xyz"], 1)


def main():
    parts, cache = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    names = sys.argv[3:] or sorted(p.name[: -len(".ply.gz")] for p in (parts / "scan").glob("*.ply.gz"))
    sys.path.insert(0, str(parts))
    import judge

    for name in names:
        out = cache / f"{name}.npz"
        if out.exists():
            continue
        truth = json.loads((parts / "truth" / f"{name}.json").read_text())
        part = judge.Part(judge.read(str(parts / "step" / f"{name}.step.gz")))
        points = points_of(parts / "scan" / f"{name}.ply.gz")
        pose = np.array(truth["scan_pose"])
        back = np.linalg.inv(pose)
        distance, _, face = part.nearest(points @ back[:3, :3].T + back[:3, 3])
        group = part.group[face]
        turn = pose[:3, :3]
        moved = []
        for members in part.members:
            parameters = {}
            for key, value in part.faces[members[0]].par.items():
                value = np.asarray(value, float)
                if key in ("n", "dir"):
                    value = turn @ value
                elif value.shape == (3,):
                    value = turn @ value + pose[:3, 3]
                parameters[key] = value.tolist()
            moved.append(parameters)
        np.savez_compressed(
            out,
            points=points,
            group=group,
            distance=distance,
            kind=np.array(part.gkind),
            width=part.gwidth,
            area=part.garea,
            parameters=np.array(json.dumps(moved)),
            scan=np.array(json.dumps(truth["meshes"]["scan"])),
        )
        print(name, len(points), part.ng, flush=True)


if __name__ == "__main__":
    main()
