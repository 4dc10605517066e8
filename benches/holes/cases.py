"""Scans with holes of every shape and known true surfaces.

    python3 -m venv VENV
    VENV/bin/pip install numpy scipy
    VENV/bin/python benches/holes/cases.py --list
    VENV/bin/python benches/holes/cases.py FOLDER [--only PATTERN] [--seed K] [--shared DIR]

The script writes FOLDER/NAME.ply (binary, millimetres) for every case whose name
matches the shell pattern, for example 'touching-*'. `evaluate.py` runs the cases.

It needs virtual_scan.py, which is not part of the project, in ../shared beside the
checkout or in DIR. Without it the exit code is 2.

Names are FAMILY-VARIANT. Cases that end in -noisy have the noise of a scanner, and
the others have none. A case is a function that returns a `Case` for a seed.
"""

import argparse
import fnmatch
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import surfaces
from scans import Grid, any_of, box, disc, less, line, lobed, ring, virtual_scan

CASES = {}

# The scans that virtual_scan.py names.
NOISE_MM = {"paper": 0.15, "roll": 0.05, "relief": 0.08}
SIDES = {"paper": 90, "roll": 200, "relief": 250}
SURFACES = {"paper": "sheet", "roll": "roll", "relief": "relief"}


@dataclass
class Case:
    """A scan. `truth` is a surface of surfaces.py, and `outer` is a place on the
    outer boundary. `arguments` are those of scan2step convert. For a `timing` case
    only the time is measured, and the run ends after the fill."""

    points: np.ndarray
    triangles: np.ndarray
    truth: object
    outer: np.ndarray
    arguments: list = field(default_factory=list)
    timing: bool = False


def case(name):
    def register(make):
        CASES[name] = make
        return make
    return register


def on_grids(name, *bases):
    """Registers a cutter(grid) as a case on each of the bases 'paper', 'roll',
    'relief', or for example 'paper-noisy'. The first one has the plain name."""
    def register(cut):
        for base in bases:
            suffix = "" if base == bases[0] else f"-{base}"
            CASES[name + suffix] = lambda seed, base=base: on_grid(cut, base, seed)
        return cut
    return register


def on_grid(cut, base, seed):
    grid = of_base(base, seed)
    cut(grid)
    return finished(grid)


def of_base(base, seed):
    name, _, noisy = base.partition("-")
    surface = getattr(virtual_scan(), SURFACES[name])
    side = SIDES[name]
    return Grid(surface, side, side, NOISE_MM[name] if noisy else 0.0, seed)


def finished(grid, **more):
    return Case(*grid.done(), surfaces.Parametric(grid.surface), grid.points[0], **more)


# Plain: the cases of virtual_scan.py.


def plain(scan, noise, seed):
    vs = virtual_scan()
    points, triangles, _ = vs.scan(scan, seed, noise)
    return Case(points, triangles, surfaces.Parametric(vs.SCANS[scan][0]), points[0])


for scan in ["paper8100", "roll40k", "relief250k"]:
    CASES[f"plain-{scan}"] = lambda seed, scan=scan: plain(scan, 0.0, seed)
    CASES[f"plain-{scan}-noisy"] = lambda seed, scan=scan: plain(scan, None, seed)


# Adjacent: one strip of triangles between holes.


@on_grids("adjacent-pair", "paper", "paper-noisy", "roll", "roll-noisy")
def adjacent_pair(grid):
    c = grid.n // 2
    grid.cut(any_of(box(c - 8, c + 8, c - 18, c - 1), box(c - 8, c + 8, c + 2, c + 18)))


@on_grids("adjacent-row", "paper", "roll-noisy")
def adjacent_row(grid):
    c = grid.n // 2
    grid.cut(any_of(*[box(c - 6, c + 6, 12 + 10 * k, 19 + 10 * k) for k in range(6)]))


@on_grids("adjacent-panes", "roll", "roll-noisy")
def adjacent_panes(grid):
    pane = lambda k: (20 + 28 * k, 45 + 28 * k)
    grid.cut(any_of(*[box(*pane(i), *pane(j)) for i in range(5) for j in range(5)]))


@on_grids("adjacent-pie", "paper", "paper-noisy", "roll")
def adjacent_pie(grid):
    """A disc that a cross of two strips divides."""
    c = grid.n // 2
    strips = any_of(lambda i, j: (i >= c) & (i <= c + 1), lambda i, j: (j >= c) & (j <= c + 1))
    grid.cut(less(disc(c + 0.5, c + 0.5, grid.n // 4), strips))


@on_grids("adjacent-nested", "paper", "paper-noisy")
def adjacent_nested(grid):
    """A C around a disc, with a strip between them and another strip at its opening."""
    c = grid.n // 2
    wall = less(ring(c, c, 11, 22), line(c, c, c + 40, c, 1.5))
    grid.cut(any_of(disc(c, c, 8), wall))


# Touching: holes that share single vertices.


@on_grids("touching-bowtie", "paper", "paper-noisy", "roll")
def touching_bowtie(grid):
    c = grid.n // 2
    grid.cut_quads(any_of(box(c - 12, c, c - 12, c), box(c, c + 12, c, c + 12)))


@on_grids("touching-discs", "paper", "paper-noisy")
def touching_discs(grid):
    """Two diamonds whose tips meet at one vertex."""
    c = grid.n // 2
    tip = lambda side: lambda i, j: (np.abs(i - c) < side * (j - c)) & (side * (j - c) < 14)
    grid.cut_triangles(any_of(tip(1), tip(-1)))


@on_grids("touching-chain", "paper", "roll-noisy")
def touching_chain(grid):
    first = grid.n // 2 - 32
    squares = [box(first + 8 * k, first + 8 * k + 8, first + 8 * k, first + 8 * k + 8) for k in range(8)]
    grid.cut_quads(any_of(*squares))


@on_grids("touching-ring", "paper", "paper-noisy", "roll")
def touching_ring(grid):
    """Squares around a centre that is attached only by vertices."""
    c = grid.n // 2
    steps = [(2, 0), (1, 1), (0, 2), (-1, 1), (-2, 0), (-1, -1), (0, -2), (1, -1)]
    at = [(c + 8 * a, c + 8 * b) for a, b in steps]
    grid.cut_quads(any_of(*[box(i - 4, i + 4, j - 4, j + 4) for i, j in at]))


@on_grids("touching-checker", "paper", "roll")
def touching_checker(grid):
    c, cells = grid.n // 2, 5
    black = lambda i, j: ((i - c) // 5 + (j - c) // 5) % 2 == 0
    inside = box(c - 5 * cells, c + 5 * cells, c - 5 * cells, c + 5 * cells)
    grid.cut_quads(lambda i, j: inside(i, j) & black(i, j))


@on_grids("touching-itself", "paper", "paper-noisy")
def touching_itself(grid):
    """A ring-shaped hole that is closed except for one vertex, so that its centre is attached by it."""
    c = grid.n // 2
    hole = ring(c, c, 8, 18)
    neck = any_of(box(c - 1, c + 1, c + 6, c + 12), box(c - 1, c + 1, c + 14, c + 20))
    grid.cut_quads(less(hole, neck, box(c - 1, c, c + 12, c + 13), box(c, c + 1, c + 13, c + 14)))


@on_grids("touching-three", "paper", "paper-noisy")
def touching_three(grid):
    """Three holes that share one vertex."""
    c = grid.n // 2
    edges = [(-1, -1), (0, 1), (1, 0)]
    fan = [lambda i, j, a=a, b=b: (np.arctan2(i - c, j - c) - np.arctan2(a, b)) % (2 * np.pi) < 0.8
           for a, b in edges]
    grid.cut_triangles(lambda i, j: disc(c, c, 12)(i, j) & any_of(*fan)(i, j))


@on_grids("touching-outer", "paper", "paper-noisy", "roll")
def touching_outer(grid):
    """A hole whose tip is one vertex of the outer boundary."""
    c = grid.n // 2
    grid.set_diagonal(0, c - 1, False)
    grid.set_diagonal(0, c, True)
    grid.kept[[grid.quad(0, c - 1)[1], grid.quad(0, c)[0]]] = False
    grid.cut_quads(box(1, 12, c - 8, c + 8))


@on_grids("touching-bay", "paper", "paper-noisy")
def touching_bay(grid):
    c = grid.n // 2
    grid.cut_quads(any_of(box(0, 10, c - 6, c), box(10, 22, c, c + 12)))


# Bays: the outer boundary has deep concavities.


@on_grids("bay-fjord", "paper", "paper-noisy", "roll")
def bay_fjord(grid):
    """A bay with a hole on either side at the distance of a strip."""
    n, c = grid.n, grid.n // 2
    bay = box(0, 0.7 * n, c - 1, c + 1)
    grid.cut(any_of(bay, box(0.3 * n, 0.5 * n, c - 14, c - 4), box(0.3 * n, 0.5 * n, c + 4, c + 14)))


@on_grids("bay-bulb", "paper", "paper-noisy")
def bay_bulb(grid):
    """A bay with an opening of one quad that is wide inside, and a hole beside it."""
    c = grid.n // 2
    grid.cut_quads(any_of(box(0, c, c, c + 1), disc(c, c, 14), disc(c, c + 30, 8)))


@on_grids("bay-comb", "paper", "roll-noisy")
def bay_comb(grid):
    """Many narrow bays with a hole at the end of each."""
    n, m = grid.n, grid.m
    at = range(10, m - 10, 9)
    fjords = [box(0, n // 2, j, j + 2) for j in at]
    grid.cut(any_of(*fjords, *[box(n // 2 + 3, n // 2 + 9, j - 2, j + 4) for j in at]))


# Islands: pieces inside a hole that are not connected to the rest.


@on_grids("islands-one", "paper", "paper-noisy", "roll", "roll-noisy", "relief")
def islands_one(grid):
    c, r = grid.n // 2, grid.n // 5
    grid.cut(ring(c, c, 0.4 * r, r))


@on_grids("islands-four", "paper", "paper-noisy", "roll-noisy")
def islands_four(grid):
    c, r = grid.n // 2, grid.n // 4
    d = 0.45 * r
    some = [disc(c + a, c + b, 0.2 * r) for a, b in [(d, d), (-d, d), (d, -d), (-d, -d)]]
    grid.cut(less(disc(c, c, r), *some))


@on_grids("islands-holed", "paper", "paper-noisy")
def islands_holed(grid):
    c = grid.n // 2
    grid.cut(any_of(ring(c, c, 13, 24), disc(c, c, 5)))


@on_grids("islands-nested", "paper", "paper-noisy", "roll")
def islands_nested(grid):
    """An island in the hole of an island."""
    c = grid.n // 2
    grid.cut(any_of(ring(c, c, 16, 26), ring(c, c, 5, 10)))


@on_grids("islands-near", "paper", "paper-noisy", "roll")
def islands_near(grid):
    """The smallest distance from the rim is an edge and a half."""
    c = grid.n // 2
    grid.cut_quads(less(disc(c, c, 18), disc(c + 7.5, c, 9)))


@on_grids("islands-tiny", "paper", "paper-noisy")
def islands_tiny(grid):
    """Islands of one, two and eight triangles."""
    c = grid.n // 2
    grid.cut_quads(less(disc(c, c, 18), box(c - 6, c - 5, c, c + 1), box(c + 4, c + 6, c - 6, c - 4)))
    one = grid.quad(c, c + 7)[0]
    grid.kept[one] = True


@on_grids("islands-many", "roll", "roll-noisy")
def islands_many(grid):
    """A hole with thirty islands of a few triangles each."""
    c = grid.n // 2
    at = np.mgrid[c - 40 : c + 41 : 14, c - 40 : c + 41 : 14].reshape(2, -1).T
    grid.cut(less(disc(c, c, 58), *[disc(i, j, 3) for i, j in at]))


@on_grids("islands-touching", "paper")
def islands_touching(grid):
    """An island that touches the rim at one vertex, and another one that touches it
    along a side that is too short to attach it."""
    c = grid.n // 2
    hole = box(c - 20, c + 20, c - 20, c + 20)
    bridged = less(box(c + 8, c + 20, c, c + 8), box(c + 19, c + 20, c + 1, c + 8))
    tip = lambda i, j: (np.abs(i - c + 8) < j - c + 20) & (j < c - 10)
    grid.cut_triangles(less(hole, bridged, tip))


# Lace: 150 small holes.


@on_grids("lace-regular", "paper", "paper-noisy", "roll", "relief-noisy")
def lace_regular(grid):
    r = 0.02 * grid.n
    rows, columns = (np.linspace(r + 3, side - r - 4, k) for side, k in [(grid.n, 10), (grid.m, 15)])
    grid.cut(any_of(*[disc(i, j, r) for i in rows for j in columns]))


@on_grids("lace-random", "paper", "paper-noisy", "roll", "relief-noisy")
def lace_random(grid):
    """Some holes merge, and some touch."""
    margin = 0.022 * grid.n + 3
    at = grid.random.uniform(margin, grid.n - 1 - margin, (150, 2))
    radii = grid.random.uniform(0.6, 0.022 * grid.n, 150)
    grid.cut(any_of(*[disc(i, j, r) for (i, j), r in zip(at, radii)]))


@on_grids("lace-tight", "paper", "paper-noisy")
def lace_tight(grid):
    """One strip of triangles between any two of them."""
    inside = box(12, 72, 5, 80)
    grid.cut(lambda i, j: inside(i, j) & (i % 5 > 1) & (j % 5 > 1))


# Fins: parts that stick out from a rim into the hole.


def with_fins(grid, count, reach, lift=0.0):
    """Single triangles on sides of the rim that point to the centre."""
    c, r = grid.n // 2, grid.n // 6
    grid.cut(disc(c, c, r))
    sides, _ = grid.rim()
    middle = np.array([0.5, 0.5])
    for a, b in sides[:: max(len(sides) // count, 1)][:count]:
        base = grid.uv[[a, b]].mean(0)
        tip = grid.add_vertex(base + reach * (middle - base), lift)
        grid.add_triangle(b, a, tip)


@on_grids("fins-teeth", "paper", "paper-noisy")
def fins_teeth(grid):
    with_fins(grid, 12, 0.15)


@on_grids("fins-needles", "paper", "paper-noisy")
def fins_needles(grid):
    with_fins(grid, 6, 0.7)


@on_grids("fins-lifted", "paper")
def fins_lifted(grid):
    """The tips are 5 mm off the surface."""
    with_fins(grid, 6, 0.15, lift=5.0)


@on_grids("fins-tongues", "paper", "paper-noisy", "roll")
def fins_tongues(grid):
    """Strips with a width of one quad, one of which almost crosses the hole."""
    c, r = grid.n // 2, 20
    tongues = [box(c, c + 1, c - r - 2, c + r - 2), box(c - 30, c - 6, c - 8, c - 7),
               box(c - 30, c - 6, c + 8, c + 9), box(c + 6, c + 30, c + 3, c + 4)]
    grid.cut_quads(less(disc(c, c, r), *tongues))


@on_grids("fins-strips", "paper", "paper-noisy")
def fins_strips(grid):
    """Diagonal strips of single triangles that touch at corners."""
    c, r = grid.n // 2, 18
    strips = [line(c - 30, c - 25 + 12 * k, c - 4, c + 1 + 12 * k, 0.45) for k in range(3)]
    grid.cut_triangles(less(disc(c, c, r), *strips))


@on_grids("fins-dangling", "paper")
def fins_dangling(grid):
    """Triangles that are attached to the rim by a vertex."""
    c, r = grid.n // 2, 15
    grid.cut(disc(c, c, r))
    sides, _ = grid.rim()
    for a, _ in sides[:: len(sides) // 8]:
        inwards = np.array([0.5, 0.5]) - grid.uv[a]
        across = 0.3 * inwards[::-1] * [1, -1]
        p = grid.add_vertex(grid.uv[a] + 0.15 * (inwards + across))
        q = grid.add_vertex(grid.uv[a] + 0.15 * (inwards - across))
        grid.add_triangle(a, *((p, q) if np.cross([*inwards, 0], [*across, 0])[2] < 0 else (q, p)))


@on_grids("fins-spikes", "paper", "paper-noisy")
def fins_spikes(grid):
    """Rim vertices that are moved 4 mm off the surface."""
    c = grid.n // 2
    grid.cut(disc(c, c, 15))
    sides, _ = grid.rim()
    for k, a in enumerate(sides[:: len(sides) // 6, 0]):
        lifted = grid.add_vertex(grid.uv[a], 4.0 * (-1) ** k)
        grid.points[a] = grid.points[lifted]


# Ragged: rims of every shape.


@on_grids("ragged-bitten", "paper", "paper-noisy", "roll", "roll-noisy")
def ragged_bitten(grid):
    """Faces along the rim are missing at random."""
    c, r = grid.n // 2, grid.n // 6
    grid.cut_triangles(disc(c, c, r))
    grid.cut_triangles(disc(c, c, r + 3), 0.45)
    grid.cut_triangles(disc(c, c, r + 6), 0.15)


@on_grids("ragged-moth", "paper", "roll-noisy")
def ragged_moth(grid):
    """A quarter of all triangles of a region is missing."""
    c = grid.n // 2
    grid.cut_triangles(disc(c, c, grid.n // 5), 0.25)


@on_grids("ragged-fjords", "paper", "paper-noisy", "roll-noisy")
def ragged_fjords(grid):
    c = grid.n // 2
    arms = [line(c, c, c + 30 * np.cos(a), c + 30 * np.sin(a), 0.8) for a in np.arange(7) * 0.9]
    grid.cut(any_of(disc(c, c, 9), *arms))


@on_grids("ragged-slit", "paper", "paper-noisy", "relief", "relief-noisy")
def ragged_slit(grid):
    """Slits with a width of one and two quads, straight and oblique."""
    n, m = grid.n, grid.m
    slanting = line(0.55 * n, 0.1 * m, 0.9 * n, 0.9 * m, 0.8)
    grid.cut_quads(any_of(box(n // 5, n // 5 + 1, 0.1 * m, 0.9 * m), slanting))
    grid.cut_quads(box(n // 3, n // 3 + 2, 0.1 * m, 0.9 * m))


@on_grids("ragged-crack", "paper", "roll")
def ragged_crack(grid):
    """Slits with a width of a fiftieth of an edge."""
    i, span = grid.n // 2, np.arange(grid.m // 5, 4 * grid.m // 5)
    for j in span:
        old = i * grid.m + j
        new = grid.add_vertex(grid.uv[old] + [0.02 / grid.n, 0])
        # The new vertices' numbers are the highest: their triangles are beyond, too.
        beyond = grid.triangles.max(1) >= (i + 1) * grid.m
        grid.triangles[(grid.triangles == old) & beyond[:, None]] = new


@on_grids("ragged-spiral", "paper", "paper-noisy", "roll-noisy")
def ragged_spiral(grid):
    c, r = grid.n // 2, 0.4 * grid.n
    def inside(i, j):
        radius, angle = np.hypot(i - c, j - c), np.arctan2(j - c, i - c)
        turn = radius / 10 - angle / (2 * np.pi)
        return (radius > 4) & (radius < r) & (turn % 1 < 0.4)
    grid.cut(inside)


@on_grids("ragged-c", "paper", "paper-noisy", "roll")
def ragged_c(grid):
    """A ring with a bridge of four quads."""
    c = grid.n // 2
    grid.cut(less(ring(c, c, 12, 24), line(c, c, c + 60, c, 2)))


@on_grids("ragged-star", "paper", "paper-noisy", "roll-noisy")
def ragged_star(grid):
    c = grid.n // 2
    grid.cut(lobed(c, c, 0.2 * grid.n, 11, 0.75))


@on_grids("ragged-dumbbell", "paper", "paper-noisy", "roll-noisy")
def ragged_dumbbell(grid):
    c, d = grid.n // 2, grid.n // 5
    grid.cut(any_of(disc(c, c - d, 0.6 * d), disc(c, c + d, 0.6 * d), line(c, c - d, c, c + d, 0.9)))


@on_grids("ragged-zigzag", "paper", "roll-noisy")
def ragged_zigzag(grid):
    """A band that turns back five times with two quads between the turns."""
    grid.cut(any_of(*zigzag(20, 18, 54, 5)))


def zigzag(i0, j0, length, turns):
    rows = [box(i0 + 6 * k, i0 + 6 * k + 2, j0, j0 + length) for k in range(turns)]
    ends = [j0 + length - 2 if k % 2 == 0 else j0 for k in range(turns - 1)]
    return rows + [box(i0 + 6 * k, i0 + 6 * k + 8, j, j + 2) for k, j in enumerate(ends)]


# Wide: a third of the surface and more.


@on_grids("wide-30", "roll", "roll-noisy", "relief", "relief-noisy")
def wide_30(grid):
    c = grid.n / 2
    grid.cut(lobed(c, c, 0.31 * grid.n, 5, 0.1))


def on_surface(name, surface, shape, side=100):
    def make(seed, noise=0.0):
        grid = Grid(getattr(surfaces, surface), side, side, noise, seed)
        return finished(grid.cut(shape(side)))
    CASES[name] = make
    CASES[f"{name}-noisy"] = lambda seed: make(seed, 0.1)


on_surface("wide-saddle", "saddle", lambda n: disc(n / 2, n / 2, 0.35 * n))
on_surface("wide-eggcrate", "egg_crate", lambda n: disc(n / 2, n / 2, 0.2 * n), 160)
on_surface("wide-cup-bottom", "cup", lambda n: disc(n / 2, n / 2, 0.3 * n))
on_surface("wide-cup-wall", "cup", lambda n: disc(0.25 * n, n / 2, 0.2 * n))


def dome(seed, noise, share):
    """A half sphere; the share of its area about the pole is a hole."""
    random, radius, rings = np.random.default_rng(seed), 40.0, 45
    rho, phi = [], []
    for k in range(rings + 1):
        number = max(6 * k, 1)
        rho += [k / rings] * number
        phi += list(2 * np.pi * (np.arange(number) + 0.5 * (k % 2)) / number)
    rho, phi = np.array(rho), np.array(phi)
    inner = rho < 1
    rho, phi = (x + inner * random.uniform(-w, w, x.size) for x, w in
                [(rho, 0.2 / rings), (phi, 0.2 / np.maximum(rho * rings, 1))])
    from scipy.spatial import Delaunay
    triangles = Delaunay(np.stack([rho * np.cos(phi), rho * np.sin(phi)], 1)).simplices
    theta = rho * np.pi / 2
    points = radius * np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1)
    points += random.normal(0, noise, points.shape)
    seen = np.cos(theta) < 1 - share
    triangles = triangles[seen[triangles].all(1)]
    used = np.unique(triangles)
    number = np.zeros(len(points), int)
    number[used] = np.arange(len(used))
    return Case(points[used], number[triangles], surfaces.Sphere(radius), points[-1])


CASES["wide-dome"] = lambda seed: dome(seed, 0.0, 0.6)
CASES["wide-dome-noisy"] = lambda seed: dome(seed, 0.1, 0.6)
CASES["wide-dome-30"] = lambda seed: dome(seed, 0.0, 0.3)


# Graded: long and short edges on one rim.


def graded(seed, noise, n, m, warp, shape):
    grid = Grid(virtual_scan().sheet, n, m, noise, seed, warp)
    return finished(grid.cut(shape))


def ten_to_one(u, v):
    """The edges in u grow tenfold over half of the range."""
    a = np.log(100)
    return np.expm1(a * np.clip(u, -1, 2)) / np.expm1(a), v


def both_ways(u, v):
    return ten_to_one(u, v)[0], ten_to_one(v, u)[0]


for suffix, sigma in [("", 0.0), ("-noisy", 0.02)]:
    CASES["graded-10" + suffix] = lambda seed, s=sigma: graded(
        seed, s, 140, 100, ten_to_one, lambda i, j: disc(0.75, 0.5, 0.2)(i / 139, j / 99))
    CASES["graded-both" + suffix] = lambda seed, s=sigma: graded(
        seed, s, 140, 140, both_ways, lambda i, j: disc(0.75, 0.75, 0.2)(i / 139, j / 139))
    CASES["graded-flat" + suffix] = lambda seed, s=sigma: graded(
        seed, s, 300, 40, None, lambda i, j: disc(0.5, 0.5, 0.2)(i / 299, j / 39))


@on_grids("graded-needles", "paper", "paper-noisy")
def graded_needles(grid):
    """Every third side of the rim has a vertex near its end."""
    c = grid.n // 2
    grid.cut(disc(c, c, 15))
    sides, owners = grid.rim()
    for (a, b), t in list(zip(sides, owners))[::3]:
        corners = grid.triangles[t]
        if not grid.kept[t]:
            continue
        third = int(corners.sum() - a - b)
        new = grid.add_vertex(0.95 * grid.uv[a] + 0.05 * grid.uv[b])
        grid.kept[t] = False
        grid.add_triangle(a, new, third)
        grid.add_triangle(new, b, third)


# Hundred: for the time of the fill alone.


def hundred(seed, rows, columns, cell, shape):
    vs = virtual_scan()
    grid = Grid(vs.relief, rows * cell[0], columns * cell[1], 0.0, seed)
    inside = lambda i, j: shape(i % cell[0], j % cell[1])
    return finished(grid.cut(inside), arguments=["--smooth", "off"], timing=True)


@case("hundred-slits")
def hundred_slits(seed):
    """A hundred slits with a width of two quads and 1,000 rim vertices each."""
    return hundred(seed, 50, 2, (6, 506), box(3, 3, 4, 500))


@case("hundred-fjords")
def hundred_fjords(seed):
    """A hundred combs of 1,000 rim vertices each."""
    comb = any_of(box(3, 5, 3, 66), lambda i, j: box(3, 33, 3, 66)(i, j) & (j % 4 == 3))
    return hundred(seed, 10, 10, (41, 74), comb)


def lobes(seed, rows, columns):
    return hundred(seed, rows, columns, (240, 240), lobed(120, 120, 80, 8, 0.4))


@case("hundred-ten")
def hundred_ten(seed):
    """Ten of the hundred holes."""
    return lobes(seed, 2, 5)


@case("hundred-lobed")
def hundred_lobed(seed):
    """A hundred almost round holes with about 1,000 rim vertices each in 4 million
    points."""
    return lobes(seed, 10, 10)


def chosen(pattern):
    return [name for name in CASES if fnmatch.fnmatch(name, pattern)]


def main():
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_it_is)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--only", default="*", metavar="PATTERN")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--shared", type=Path)
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    if options.list or not options.folder:
        print("\n".join(chosen(options.only)))
        return
    vs = virtual_scan(options.shared)
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in chosen(options.only):
        made = CASES[name](options.seed)
        vs.write_ply(options.folder / f"{name}.ply", made.points, made.triangles)
        print(f"{name}: {len(made.points)} vertices, {len(made.triangles)} triangles", flush=True)


if __name__ == "__main__":
    main()
