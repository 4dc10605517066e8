"""Writes the scan of the comparison in every format.

    python benches/peers/scan.py FOLDER [SIDE]

The scan is a relief of 100 x 80 mm as a grid of SIDE x SIDE points (default: 1000). It is jittered
and noisy and has holes, one of which has an island. The numbers are the same in all formats:
float32, or six decimals in OBJ.
"""

import json
import struct
import sys
from pathlib import Path

import numpy as np

NOISE_MM = 0.02

# The centres in the unit square and the radii. The last two make a ring.
HOLES = [(0.3, 0.35, 0.05), (0.7, 0.25, 0.03), (0.25, 0.75, 0.02)]
RING = (0.7, 0.7, 0.02, 0.04)


def relief(side):
    """The points and the triangles."""
    random = np.random.default_rng(1)
    v, u = np.divmod(np.arange(side * side), side) / np.float64(side - 1)
    u, v = (w + random.uniform(-0.3, 0.3, w.size) / side for w in (u, v))
    x, y = 100 * (u - 0.5), 80 * (v - 0.5)
    z = 18 * np.exp(-(x * x + y * y) / 1800) + 0.8 * np.sin(x / 3) * np.cos(y / 4)
    points = np.stack([x, y, z], axis=1) + random.normal(0, NOISE_MM, (u.size, 3))

    seen = np.ones(u.size, bool)
    for a, b, radius in HOLES:
        seen &= np.hypot(u - a, v - b) > radius
    a, b, inner, outer = RING
    distance = np.hypot(u - a, v - b)
    seen &= (distance < inner) | (distance > outer)

    corner = np.arange(side * side).reshape(side, side)
    quads = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    p, q, r, s = (corners.ravel() for corners in quads)
    triangles = np.concatenate([np.stack([p, q, r], 1), np.stack([p, r, s], 1)], 1).reshape(-1, 3)
    triangles = without_bow_ties(triangles[seen[triangles].all(axis=1)], side * side)

    used = np.unique(triangles)
    number = np.zeros(side * side, np.uint32)
    number[used] = np.arange(used.size)
    return points[used].astype("<f4"), number[triangles].astype("<u4")


def without_bow_ties(triangles, count):
    """Removes triangles until no vertex has two gaps in its one-ring. A vertex has as
    many triangles as edges, or one less on the boundary."""
    while True:
        sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges = np.unique(sides[:, 0] * count + sides[:, 1])
        degree = np.bincount(np.concatenate(np.divmod(edges, count)), minlength=count)
        gaps = degree - np.bincount(triangles.ravel(), minlength=count)
        bad = (gaps > 1)[triangles].any(axis=1)
        if not bad.any():
            return triangles
        triangles = triangles[~bad]


def write_ply(path, points, triangles):
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, triangles
    path.write_bytes(header.encode() + points.tobytes() + faces.tobytes())


def write_stl(path, points, triangles):
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    record = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]
    facets = np.zeros(len(triangles), record)
    facets["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    facets["corners"] = corners
    path.write_bytes(bytes(80) + struct.pack("<I", len(triangles)) + facets.tobytes())


def write_glb(path, points, triangles):
    data = points.tobytes() + triangles.tobytes()
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes, "target": 34962},
        {"buffer": 0, "byteOffset": points.nbytes, "byteLength": triangles.nbytes, "target": 34963},
    ]
    box = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"} | box,
        {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
    ]
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def write_obj(path, points, triangles):
    with path.open("w") as file:
        for line, rows in [("v %.6f %.6f %.6f\n", points), ("f %d %d %d\n", triangles + 1)]:
            for some in np.array_split(rows, 1 + len(rows) // 100_000):
                file.write(line * len(some) % tuple(some.ravel().tolist()))


WRITERS = {"ply": write_ply, "glb": write_glb, "stl": write_stl, "obj": write_obj}


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    points, triangles = relief(int(sys.argv[2]) if len(sys.argv) > 2 else 1000)
    for ending, write in WRITERS.items():
        write(folder / f"scan.{ending}", points, triangles)
    print(f"{len(points)} vertices, {len(triangles)} triangles")


if __name__ == "__main__":
    main()
