"""The true surfaces of scans and fills.

A true surface has `foot(points)`: the distance of each point from the surface, and the
unit normal of the surface at the foot point.
"""

import functools

import numpy as np
from scipy.spatial import cKDTree

SAMPLES = 500
STEPS = 6
STEP = 1e-6


class Parametric:
    """A surface f(u, v) over the unit square. Foot points are found by Newton steps in
    (u, v) from the nearest of many samples."""

    def __init__(self, f):
        self.f = f

    def foot(self, points):
        u, v = self.nearest(points)
        best = self.distance(u, v, points)
        for _ in range(STEPS):
            du, dv = self.step(u, v, points)
            new_u, new_v = np.clip(u + du, 0, 1), np.clip(v + dv, 0, 1)
            distance = self.distance(new_u, new_v, points)
            better = distance < best
            u, v = np.where(better, new_u, u), np.where(better, new_v, v)
            best = np.where(better, distance, best)
        return best, self.normal(u, v)

    def nearest(self, points):
        tree, u, v = samples(self.f)
        _, at = tree.query(points, workers=2)
        return u[at], v[at]

    def distance(self, u, v, points):
        return np.linalg.norm(self.f(u, v) - points, axis=1)

    def derivatives(self, u, v):
        f, e = self.f, STEP
        return (f(u + e, v) - f(u - e, v)) / (2 * e), (f(u, v + e) - f(u, v - e)) / (2 * e)

    def step(self, u, v, points):
        fu, fv = self.derivatives(u, v)
        rest = points - self.f(u, v)
        a, b, c = dot(fu, fu), dot(fu, fv), dot(fv, fv)
        x, y = dot(fu, rest), dot(fv, rest)
        det = np.maximum(a * c - b * b, 1e-300)
        return (c * x - b * y) / det, (a * y - b * x) / det

    def normal(self, u, v):
        return unit(np.cross(*self.derivatives(u, v)))


class Sphere:
    """A sphere around the origin with an outward normal."""

    def __init__(self, radius):
        self.radius = radius

    def foot(self, points):
        length = np.linalg.norm(points, axis=1)
        return np.abs(length - self.radius), unit(points)


@functools.lru_cache(maxsize=4)
def samples(f):
    u, v = np.meshgrid(*2 * [np.linspace(0, 1, SAMPLES)], indexing="ij")
    return cKDTree(f(u, v).reshape(-1, 3)), u.ravel(), v.ravel()


def dot(a, b):
    return np.einsum("ij,ij->i", a, b)


def unit(a):
    return a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-300)


def saddle(u, v):
    """A surface with slopes of 2 at the sides."""
    x, y = 100 * (u - 0.5), 100 * (v - 0.5)
    return np.stack([x, y, (x * x - y * y) / 50], -1)


def egg_crate(u, v):
    """Bumps at distances of 20 mm with slopes of up to 1.9."""
    x, y = 100 * u, 100 * v
    return np.stack([x, y, 6 * np.sin(x / 3.2) * np.sin(y / 3.2)], -1)


def cup(u, v):
    """A bowl whose wall is four times as steep as its radius is wide."""
    x, y = 60 * (u - 0.5), 60 * (v - 0.5)
    return np.stack([x, y, (x * x + y * y) / 15], -1)
