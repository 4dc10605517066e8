"""A filled mesh that `scan2step convert --stages` has written, and its properties:
topology, angles, lengths, folds.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surfaces import dot, unit

TYPES = {"double": "<f8", "float": "<f4", "uchar": "u1", "int": "<i4"}


class Filled:
    """`hole` is the number of the hole that a face fills, or -1 for a measured face.
    `added` tells for each vertex whether the fill has added it."""

    def __init__(self, points, triangles, added, hole):
        self.points, self.triangles = points, triangles
        self.added, self.hole = added, hole
        self.fill = np.flatnonzero(hole >= 0)
        self.measured = np.flatnonzero(hole < 0)
        corners = points[triangles]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.areas = np.linalg.norm(cross, axis=1) / 2
        self.normals = unit(cross)
        self.centroids = corners.mean(1)
        self.edges = Edges(triangles, len(points))


class Edges:
    """Edges of triangles. `of_side` has the edge of side k of triangle t at [t, k].
    `faces` has two triangles of each edge. The second is -1 if there is none."""

    def __init__(self, triangles, count):
        sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        key = sides.min(1) * count + sides.max(1)
        unique, inverse, self.uses = np.unique(key, return_inverse=True, return_counts=True)
        self.of_side = inverse.reshape(-1, 3)
        self.ends = np.stack(np.divmod(unique, count), 1)
        forward = np.bincount(inverse, sides[:, 0] < sides[:, 1], len(unique))
        # In two triangles with the same orientation, the edge has opposite directions.
        self.disagree = (self.uses == 2) & (forward != 1)
        order = np.argsort(inverse, kind="stable")
        first = np.concatenate([[0], np.cumsum(self.uses)[:-1]])
        second = np.where(self.uses > 1, first + 1, first)
        self.faces = np.stack([order[first] // 3, order[second] // 3], 1)
        self.faces[self.uses == 1, 1] = -1


def read_filled(path):
    """None if the file is not that of the fill stage, or is not complete."""
    data = np.memmap(path, np.uint8, "r")
    found = layout(bytes(data[:1000]))
    if found is None:
        return None
    start, vertices, faces = found
    if len(data) < start + sum(t.itemsize * n for n, t in (vertices, faces)):
        return None
    v = np.frombuffer(data, vertices[1], vertices[0], start)
    f = np.frombuffer(data, faces[1], faces[0], start + v.nbytes)
    points = np.stack([v["x"], v["y"], v["z"]], 1)
    return Filled(points, f["corners"].astype(np.int64), v["origin"] == 1, f["hole"].astype(int))


def is_filled(head, size):
    """Whether these first bytes of a file of this size belong to a complete file."""
    found = layout(head)
    return found is not None and size >= found[0] + sum(t.itemsize * n for n, t in found[1:])


def layout(head):
    """The start of the data, and the numbers and types of vertices and of faces."""
    text, end, _ = head.partition(b"end_header\n")
    if not end or b"uchar origin" not in text or b"double u" in text:
        return None
    counts = [int(line.split()[2]) for line in text.splitlines() if line.startswith(b"element")]
    vertex = np.dtype([("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("origin", "u1")])
    face = np.dtype([("n", "u1"), ("corners", "<i4", 3), ("hole", "<i4")])
    return len(text) + len(end), (counts[0], vertex), (counts[1], face)


def topology(mesh):
    """The faults of the mesh. A disk has 0, 0, 0, and 1 loop and component."""
    edges = mesh.edges
    return {
        "nonmanifold_edges": int((edges.uses > 2).sum()),
        "more_fans": int((fans(mesh) > 1).sum()),
        "loops": loops(edges, len(mesh.points)),
        "disagreeing_edges": int(edges.disagree.sum()),
        "components": int(components(mesh, np.arange(len(mesh.triangles))).max(initial=-1)) + 1,
        "euler": int(len(np.unique(mesh.triangles)) - len(edges.uses) + len(mesh.triangles)),
    }


def fans(mesh):
    """The fans of triangles at each vertex: corners that are joined across shared sides."""
    t, edges = mesh.triangles, mesh.edges
    joins = []
    for end in (0, 1):
        vertex = edges.ends[:, end]
        two = edges.uses >= 2
        corner = [3 * edges.faces[two, k] + np.argmax(t[edges.faces[two, k]] == vertex[two, None], 1)
                  for k in (0, 1)]
        joins.append(np.stack(corner))
    a, b = np.concatenate(joins, 1)
    graph = coo_array((np.ones(len(a), bool), (a, b)), shape=2 * [3 * len(t)])
    _, fan = connected_components(graph, directed=False)
    _, first = np.unique(fan, return_index=True)
    return np.bincount(t.reshape(-1)[first], minlength=len(mesh.points))


def loops(edges, count):
    """Connected pieces of the boundary."""
    open_edges = edges.ends[edges.uses == 1]
    graph = coo_array((np.ones(len(open_edges), bool), open_edges.T), shape=2 * [count])
    _, label = connected_components(graph, directed=False)
    return len(np.unique(label[open_edges[:, 0]]))


def is_boundary(mesh, place):
    """Whether the boundary comes within five edges of a place."""
    boundary = np.unique(mesh.edges.ends[mesh.edges.uses == 1])
    distance = np.linalg.norm(mesh.points[boundary] - place, axis=1).min(initial=np.inf)
    nearest = np.linalg.norm(mesh.points - place, axis=1).argmin()
    own = lengths(mesh, (mesh.edges.ends == nearest).any(1))
    return bool(distance <= 5 * own.mean())


def components(mesh, faces):
    """The number of each face's component, which is connected across edges."""
    within = np.full(len(mesh.triangles) + 1, -1)
    within[faces] = np.arange(len(faces))
    pairs = within[mesh.edges.faces]
    pairs = pairs[(mesh.edges.faces[:, 1] >= 0) & (pairs >= 0).all(1)]
    graph = coo_array((np.ones(len(pairs), bool), pairs.T), shape=2 * [len(faces)])
    return connected_components(graph, directed=False)[1]


def islands(mesh):
    """The measured faces that are not in the largest measured component."""
    label = components(mesh, mesh.measured)
    return mesh.measured[label != np.bincount(label).argmax()]


def min_angles(mesh, faces):
    """The smallest angle of each face in degrees. It is 0 for faces without area."""
    corners = mesh.points[mesh.triangles[faces]]
    least = np.full(len(faces), 180.0)
    for k in range(3):
        a = unit(corners[:, (k + 1) % 3] - corners[:, k])
        b = unit(corners[:, (k + 2) % 3] - corners[:, k])
        least = np.minimum(least, np.degrees(np.arccos(np.clip(dot(a, b), -1, 1))))
    return np.where(mesh.areas[faces] > 0, least, 0.0)


def lengths(mesh, which):
    ends = mesh.points[mesh.edges.ends[which]]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def bends(mesh, which):
    """The angle between the normals on both sides of each edge, in degrees."""
    a, b = (mesh.normals[mesh.edges.faces[which, k]] for k in (0, 1))
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), dot(a, b)))


def kinds(mesh):
    """The number of filled faces of each edge, or -1 unless it has two faces."""
    filled = (mesh.hole >= 0)[mesh.edges.faces].sum(1)
    return np.where(mesh.edges.uses == 2, filled, -1)
