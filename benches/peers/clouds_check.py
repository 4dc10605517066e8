"""Checks meshes of the relief that `clouds.py` makes clouds of."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

# The size of the relief in mm, and the centres and radii of its holes in the unit square, as in
# examples/virtual_scan.
SIZE = np.array([160.0, 220.0])
HOLES = [(0.5, 0.2, 0.05), (0.3, 0.63, 0.04), (0.72, 0.5, 0.03)]


@dataclass
class Found:
    """What a mesh is like."""

    manifold: bool
    oriented: bool
    pieces: int
    true_loops: int
    false_loops: int
    area: float
    used: np.ndarray


def check(points, triangles):
    """Checks a mesh. Pieces of less than one triangle in a hundred are not counted, but the loops
    around them are."""
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key = sides.min(axis=1) * len(points) + sides.max(axis=1)
    order = np.argsort(key, kind="stable")
    _, first, number, count = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
    forward = np.bincount(number, sides[:, 0] < sides[:, 1])
    boundary = sides[first[count == 1]]
    used = np.unique(triangles)
    owner = np.repeat(np.arange(len(triangles)), 3)[order]
    same = key[order][1:] == key[order][:-1]
    joined = coo_matrix((np.ones(same.sum()), (owner[:-1][same], owner[1:][same])), shape=(len(triangles),) * 2)
    sizes = np.bincount(connected_components(joined, directed=False)[1])
    manifold = bool((count <= 2).all()) and single_fans(triangles, number, len(points))
    oriented = bool(np.isin(forward[count == 2], [1]).all())
    loops = [points[loop, :2] / SIZE + 0.5 for loop in loops_of(boundary)]
    true = sum(any(is_around(loop, hole) for loop in loops) for hole in HOLES)
    true += any(np.ptp(loop, axis=0).min() > 0.9 for loop in loops)
    a, b, c = (points[triangles[:, i], :2] for i in range(3))
    (p, q), (r, s) = (b - a).T, (c - a).T
    area = abs(float((p * s - q * r).sum() / 2))
    pieces = int((sizes >= 0.01 * len(triangles)).sum())
    return Found(manifold, oriented, pieces, int(true), len(loops) - int(true), area, points[used])


def is_around(loop, hole):
    """Whether a loop in the unit square is the rim of a hole."""
    *centre, radius = hole
    size = np.ptp(loop, axis=0).mean() / 2
    return np.linalg.norm(loop.mean(axis=0) - centre) < radius and 0.6 < size / radius < 1.6


def single_fans(triangles, edge, count):
    """Whether the triangles at every vertex are joined by edges at it."""
    corner = np.arange(triangles.size).reshape(-1, 3)
    # Both corners of a side, once for each triangle.
    side = edge.reshape(-1, 3)
    ends = [np.stack([side[:, i], corner[:, j], triangles[:, j]], 1) for i in range(3) for j in (i, (i + 1) % 3)]
    ends = np.concatenate(ends)
    ends = ends[np.lexsort((ends[:, 2], ends[:, 0]))]
    same = (ends[1:, [0, 2]] == ends[:-1, [0, 2]]).all(axis=1)
    joined = coo_matrix((np.ones(same.sum()), (ends[:-1, 1][same], ends[1:, 1][same])), shape=(corner.size,) * 2)
    fans = connected_components(joined, directed=False)[0]
    return fans == len(np.unique(triangles))


def loops_of(boundary):
    """The vertices of each boundary loop. At a vertex of several loops these count as one."""
    if len(boundary) == 0:
        return []
    vertices, number = np.unique(boundary, return_inverse=True)
    number = number.reshape(boundary.shape)
    joined = coo_matrix((np.ones(len(number)), number.T), shape=(len(vertices),) * 2)
    count, label = connected_components(joined, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(vertices[order], np.searchsorted(label[order], np.arange(1, count)))
