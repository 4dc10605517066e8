"""Intersections of triangles that are near each other.

The test uses the signs of volumes in double precision. Values below a billionth of
the triangles' size count as zero. Triangles in one plane are tested with separating
axes. A shared corner or side is not an intersection, unless more than that is shared.
"""

import numpy as np
from scipy.spatial import cKDTree

from surfaces import dot

NOTHING = 1e-9
AT_ONCE = 200_000


def cutting_pairs(points, triangles, fill):
    """Pairs of triangles that intersect. The first one is of `fill`. Only triangles
    near `fill` are tested, so call this for one hole at a time."""
    pairs = near_pairs(points, triangles, fill)
    found = [part[cut(points, triangles, part)] for part in np.array_split(
        pairs, max(1, len(pairs) // AT_ONCE))]
    return np.concatenate(found)


def near_pairs(points, triangles, fill):
    """The pairs whose boxes overlap, each once. At least one of each pair is of `fill`."""
    corners = points[triangles]
    low, high = corners.min(1), corners.max(1)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    size = np.ceil(np.log2(np.maximum(reach, 1e-12))).astype(int)
    in_fill = np.zeros(len(triangles), bool)
    in_fill[fill] = True
    # Only faces at the fill can be near it.
    box_low, box_high = low[fill].min(0), high[fill].max(0)
    at_fill = ((low <= box_high) & (high >= box_low)).all(1)
    found = [np.empty((0, 2), int)]
    for a in np.unique(size[fill]):
        ones = np.flatnonzero(in_fill & (size == a))
        tree = cKDTree(middle[ones])
        for b in np.unique(size[at_fill]):
            others = np.flatnonzero(at_fill & (size == b))
            within = reach[ones].max() + reach[others].max()
            near = neighbours(tree, middle[others], within)
            pairs = np.stack([ones[near[0]], others[near[1]]], 1)
            i, j = pairs.T
            once = (i != j) & ~(in_fill[j] & (j < i))
            boxes = (low[i] <= high[j]).all(1) & (low[j] <= high[i]).all(1)
            found.append(pairs[once & boxes])
    return np.concatenate(found)


def neighbours(tree, places, within):
    """The numbers in the tree and among the places."""
    lists = tree.query_ball_point(places, within, workers=2)
    counts = np.fromiter(map(len, lists), int, len(lists))
    if counts.sum() == 0:
        return np.empty((2, 0), int)
    return np.stack([np.concatenate(lists).astype(int), np.repeat(np.arange(len(lists)), counts)])


def cut(points, triangles, pairs):
    """Whether the triangles of each pair intersect."""
    if len(pairs) == 0:
        return np.zeros(0, bool)
    a, b = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    shared = (a[:, :, None] == b[:, None, :]).any(2).sum(1)
    p, q = points[a], points[b]
    size = np.maximum(extent(p), extent(q))
    result = shared == 3
    flat = np.abs(heights(p, q)).max(1) <= NOTHING * size
    flat &= np.abs(heights(q, p)).max(1) <= NOTHING * size
    result[flat] |= overlap(p[flat], q[flat], size[flat])
    open_pairs = ~flat & (shared < 2)
    for k in range(3):
        ends = [k, (k + 1) % 3]
        for one, other, ones, others in ((p, q, a, b), (q, p, b, a)):
            # A side from a shared corner meets the other triangle there.
            free = open_pairs & ~(ones[:, ends, None] == others[:, None, :]).any((1, 2))
            result[free] |= pierces(one[free][:, ends], other[free], size[free])
    return result


def extent(p):
    return (p.max(1) - p.min(1)).max(1)


def heights(p, q):
    """The heights of the corners of q over the plane of p."""
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return np.einsum("ijk,ik->ij", q - p[:, :1], normal)


def pierces(side, p, size):
    """Whether a side passes through the inside of a triangle."""
    least = NOTHING * size**3
    volume = lambda a, b, c, d: dot(np.cross(b - a, c - a), d - a)
    s, t = side[:, 0], side[:, 1]
    below, above = (volume(p[:, 0], p[:, 1], p[:, 2], end) for end in (s, t))
    through = np.minimum(below, above) < -least
    through &= np.maximum(below, above) > least
    around = [volume(s, t, p[:, k], p[:, (k + 1) % 3]) for k in range(3)]
    inside = (np.min(around, 0) > least) | (np.max(around, 0) < -least)
    return through & inside


def overlap(p, q, size):
    """For triangles in one plane: whether no line of a side separates them."""
    if len(p) == 0:
        return np.zeros(0, bool)
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    drop = np.abs(normal).argmax(1)
    keep = np.array([[1, 2], [0, 2], [0, 1]])[drop]
    flat = [np.take_along_axis(t, keep[:, None, :], 2) for t in (p, q)]
    apart = np.zeros(len(p), bool)
    for t in flat:
        for k in range(3):
            side = t[:, (k + 1) % 3] - t[:, k]
            across = np.stack([-side[:, 1], side[:, 0]], 1)
            across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
            one, other = (np.einsum("ijk,ik->ij", f, across) for f in flat)
            gap = np.maximum(one.min(1) - other.max(1), other.min(1) - one.max(1))
            apart |= gap > -1e-7 * size
    return ~apart
