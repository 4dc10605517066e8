"""The same meshes as other files would state them: rounded, far away, in other units, turned, split."""

import math

import numpy as np


def read_stl(data):
    """The triangles of a binary STL, as an array of shape (n, 3, 3)."""
    count = int.from_bytes(data[80:84], "little")
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(data, kind, count, 84)["corners"].astype(float)


def binary(corners):
    """A binary STL of triangles."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.zeros(len(corners), kind)
    records["corners"] = corners
    return bytes(80) + len(corners).to_bytes(4, "little") + records.tobytes()


def ascii_stl(corners, places):
    """An ASCII STL with so many decimal places."""
    lines = ["solid part"]
    for triangle in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(f"{x:.{places}f}" for x in p) for p in triangle]
        lines += ["endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid part"]) + "\n").encode()


def turn():
    """A rotation about no axis of the world."""
    axis = np.array([0.36, -0.48, 0.8])
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(1.1) * k + (1 - math.cos(1.1)) * k @ k


def split(corners):
    """Every triangle cut into four at the middles of its edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.concatenate([np.stack(part, 1) for part in parts])


def diagonal(corners):
    points = corners.reshape(-1, 3)
    return np.linalg.norm(points.max(0) - points.min(0))


def identity():
    return np.eye(4)


def moved(matrix=None, scale=1.0, shift=(0.0, 0.0, 0.0)):
    pose = np.eye(4)
    pose[:3, :3] = scale * (np.eye(3) if matrix is None else matrix)
    pose[:3, 3] = shift
    return pose


def apply(pose, corners):
    return corners @ pose[:3, :3].T + pose[:3, 3]


def variant(name, corners):
    """The file of a variant, and the pose that takes the part's coordinates to it."""
    if name.startswith("dec"):
        return ascii_stl(corners, int(name[3:])), identity()
    if name == "split":
        return binary(split(corners)), identity()
    pose = {
        "exact": identity,
        "turned": lambda: moved(turn()),
        "metres": lambda: moved(turn(), 0.001),
        "inches": lambda: moved(scale=1 / 25.4),
        "far": lambda: moved(shift=np.array([3.0, -2.0, 1.0]) * 3 * diagonal(corners)),
    }[name]()
    return binary(apply(pose, corners)), pose


NAMES = ["exact", "dec3", "dec4", "far", "turned", "metres", "inches", "split"]
