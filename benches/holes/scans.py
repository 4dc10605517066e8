"""Scans that get holes: sampled grids of a true surface.

This needs virtual_scan.py, which is not part of the project.
"""

import sys
from pathlib import Path

import numpy as np

SHARED = Path(__file__).resolve().parents[3] / "shared"


def virtual_scan(shared=None):
    """Imports the module, or ends the program."""
    if "virtual_scan" in sys.modules:
        return sys.modules["virtual_scan"]
    folder = Path(shared or SHARED)
    if not (folder / "virtual_scan.py").exists():
        print(f"NOT MEASURED: {folder / 'virtual_scan.py'} is absent (--shared DIR)", file=sys.stderr)
        sys.exit(2)
    sys.path.insert(0, str(folder))
    import virtual_scan as module

    return module


class Grid:
    """A jittered n x m sampling of a surface, from which parts are removed.

    Places are grid coordinates (i, j). Vertices are at integers, and the centres of
    quads are between them. A shape is a function that tells whether (i, j) is inside.
    """

    def __init__(self, surface, n, m, noise=0.0, seed=0, warp=None):
        vs = virtual_scan()
        self.surface, self.n, self.m = surface, n, m
        self.seen = surface if warp is None else lambda u, v: surface(*warp(u, v))
        vs.SCANS["grid"] = (self.seen, n, m, noise, [])
        self.points, self.triangles, self.uv = vs.scan("grid", seed)
        self.kept = np.ones(len(self.triangles), bool)
        self.random = np.random.default_rng(seed + 1000)

    def vertices(self):
        return np.divmod(np.arange(self.n * self.m), self.m)

    def quads(self):
        """The centres of the quads. Triangles q and q + quads belong to quad q."""
        i, j = np.divmod(np.arange((self.n - 1) * (self.m - 1)), self.m - 1)
        return i + 0.5, j + 0.5

    def middles(self):
        """The centres of the triangles."""
        i, j = self.vertices()
        return i[self.triangles].mean(1), j[self.triangles].mean(1)

    def cut(self, shape):
        """Removes the vertices in the shape and their triangles."""
        gone = np.zeros(len(self.points), bool)
        gone[: self.n * self.m] = shape(*self.vertices())
        self.kept &= ~gone[self.triangles].any(1)
        return self

    def cut_quads(self, shape):
        """Removes the quads in the shape."""
        gone = np.tile(shape(*self.quads()), 2)
        self.kept[: len(gone)] &= ~gone
        return self

    def cut_triangles(self, shape, share=1.0):
        """Removes a random share of the triangles in the shape."""
        some = self.random.random(len(self.triangles)) < share
        self.kept &= ~(shape(*self.middles()) & some)
        return self

    def quad(self, i, j):
        """The numbers of its first and second triangle."""
        first = i * (self.m - 1) + j
        return first, first + (self.n - 1) * (self.m - 1)

    def set_diagonal(self, i, j, from_lowest):
        """Divides a quad along the diagonal that begins at (i, j), or along the other one."""
        a, d = i * self.m + j, i * self.m + j + 1
        b, c = a + self.m, d + self.m
        halves = ([a, b, c], [a, c, d]) if from_lowest else ([a, b, d], [b, c, d])
        for t, half in zip(self.quad(i, j), halves):
            self.triangles[t] = half

    def add_vertex(self, uv, lift=0.0):
        """Adds a vertex on the surface, or at a distance from it."""
        u, v = np.array([uv[0]]), np.array([uv[1]])
        point = self.seen(u, v)[0]
        if lift:
            e = 1e-5
            normal = np.cross(self.seen(u + e, v) - self.seen(u - e, v),
                              self.seen(u, v + e) - self.seen(u, v - e))[0]
            point = point + lift * normal / np.linalg.norm(normal)
        self.points = np.vstack([self.points, point])
        self.uv = np.vstack([self.uv, uv])
        return len(self.points) - 1

    def add_triangle(self, a, b, c):
        self.triangles = np.vstack([self.triangles, [a, b, c]])
        self.kept = np.append(self.kept, True)

    def rim(self):
        """The sides (a, b) of kept triangles without a second triangle, and these
        triangles. The outer boundary is omitted."""
        kept = np.flatnonzero(self.kept)
        t = self.triangles[kept]
        sides = t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        key = np.sort(sides, 1) @ [len(self.points), 1]
        _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
        i, j = np.divmod(sides, self.m)
        border = (i == 0) | (j == 0) | (i == self.n - 1) | (j == self.m - 1)
        single = (count[inverse] == 1) & ~border.all(1)
        return sides[single], np.repeat(kept, 3)[single]

    def done(self):
        """The points and the triangles."""
        triangles = self.triangles[self.kept]
        used = np.unique(triangles)
        number = np.zeros(len(self.points), np.int64)
        number[used] = np.arange(len(used))
        return self.points[used], number[triangles]


def box(i0, i1, j0, j1):
    return lambda i, j: (i >= i0) & (i <= i1) & (j >= j0) & (j <= j1)


def disc(ci, cj, r):
    return lambda i, j: np.hypot(i - ci, j - cj) <= r


def ring(ci, cj, inner, outer):
    return less(disc(ci, cj, outer), disc(ci, cj, inner))


def lobed(ci, cj, r, lobes, depth, turn=0.7):
    def inside(i, j):
        angle = np.arctan2(j - cj, i - ci)
        return np.hypot(i - ci, j - cj) < r * (1 + depth * np.cos(lobes * angle + turn))
    return inside


def line(i0, j0, i1, j1, half):
    """The points within half a width of a segment."""
    def inside(i, j):
        di, dj = i1 - i0, j1 - j0
        t = np.clip(((i - i0) * di + (j - j0) * dj) / (di * di + dj * dj), 0, 1)
        return np.hypot(i - i0 - t * di, j - j0 - t * dj) <= half
    return inside


def any_of(*shapes):
    return lambda i, j: np.any([shape(i, j) for shape in shapes], axis=0)


def less(shape, *others):
    return lambda i, j: shape(i, j) & ~any_of(*others)(i, j)
