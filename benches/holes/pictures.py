"""Two views of a filled hole as PNG: from its normal, and from the side.

Measured faces are grey, faces of islands are blue, and the fill is orange. Filled faces
with the opposite normal are red. Sides are dark. The pictures are a raster of the
triangles with the nearest one on top and need no library.
"""

import struct
import zlib

import numpy as np

import meshes
from surfaces import unit

SIZE = 700
GREY, BLUE, ORANGE, RED = (np.array(c, float) for c in
                           [(190, 190, 190), (90, 140, 220), (255, 165, 60), (220, 30, 30)])
SIDE = 0.55
TILT = np.radians(65)
AROUND = 1.25


def draw(mesh, result, folder, most):
    """The worst holes, at most `most` of them, and all holes together."""
    folder.mkdir(parents=True, exist_ok=True)
    island = np.zeros(len(mesh.triangles), bool)
    island[meshes.islands(mesh)] = True
    badness = lambda h: (h["folded"] + h["cuts_fill"] + h["cuts_measured"], h["area_max_mm"] or 0)
    for hole in sorted(result["holes"], key=badness, reverse=True)[:most]:
        fill = mesh.fill[mesh.hole[mesh.fill] == hole["hole"]]
        write_png(folder / f"hole-{hole['hole']}.png", views(mesh, fill, near(mesh, fill), island))
    everything = np.arange(len(mesh.triangles))
    write_png(folder / "all.png", views(mesh, everything, everything, island))


def near(mesh, fill):
    """The faces around a hole."""
    points = mesh.points[mesh.triangles[fill]].reshape(-1, 3)
    middle = (points.min(0) + points.max(0)) / 2
    reach = AROUND * np.linalg.norm(points - middle, axis=1).max()
    return np.flatnonzero(np.linalg.norm(mesh.centroids - middle, axis=1) < reach)


def views(mesh, fill, faces, island):
    up = mean_normal(mesh, fill)
    right = unit(np.cross(up, np.eye(3)[np.abs(up).argmin()]))
    back = np.cross(up, right)
    oblique = np.stack([right, np.cos(TILT) * back + np.sin(TILT) * up,
                        np.cos(TILT) * up - np.sin(TILT) * back])
    return np.hstack([view(mesh, faces, island, axes)
                      for axes in (np.stack([right, back, up]), oblique)])


def mean_normal(mesh, fill):
    """The normal of the measured faces at the hole, because the fill may be wrong."""
    about = near(mesh, fill)
    about = about[mesh.hole[about] < 0]
    about = about if len(about) else fill
    return unit((mesh.normals[about] * mesh.areas[about, None]).sum(0))


def view(mesh, faces, island, axes):
    """An image. The axes point to the right, up, and to the viewer."""
    corners = mesh.points[mesh.triangles[faces]] @ axes.T
    low, high = corners.min((0, 1)), corners.max((0, 1))
    scale = (SIZE - 20) / max(high[:2] - low[:2])
    corners = (corners - (low + high) / 2) * [scale, -scale, scale] + [SIZE / 2, SIZE / 2, 0]
    normal = mesh.normals[faces] @ axes.T
    colours = coloured(mesh, faces, island, normal)
    image = np.full((SIZE * SIZE, 3), 255.0)
    face, pixel, depth, edge = fragments(corners)
    order = np.argsort(depth, kind="stable")
    face, pixel, edge = face[order], pixel[order], edge[order]
    image[pixel] = colours[face] * np.where(edge, SIDE, 1.0)[:, None]
    return image.reshape(SIZE, SIZE, 3).astype(np.uint8)


def coloured(mesh, faces, island, normal):
    filled = mesh.hole[faces] >= 0
    colours = np.where(filled[:, None], ORANGE, np.where(island[faces][:, None], BLUE, GREY))
    colours[filled & (normal[:, 2] <= 0)] = RED
    light = unit(np.array([-0.4, 0.5, 0.8]))
    return colours * (0.45 + 0.55 * np.abs(normal @ light))[:, None]


def fragments(corners):
    """Every pixel that a triangle covers: the face, the pixel, the depth, and whether it
    is at a side."""
    low = np.clip(np.floor(corners[:, :, :2].min(1)), 0, SIZE - 1).astype(int)
    high = np.clip(np.ceil(corners[:, :, :2].max(1)), 0, SIZE - 1).astype(int)
    width, height = (high - low + 1).T
    face = np.repeat(np.arange(len(corners)), width * height)
    first = np.repeat(np.cumsum(width * height) - width * height, width * height)
    dy, dx = np.divmod(np.arange(len(face)) - first, width[face])
    at = low[face] + np.stack([dx, dy], 1)
    weights, across = barycentric(corners, face, at + 0.5)
    inside = (weights >= 0).all(1)
    face, at, weights = face[inside], at[inside], weights[inside]
    depth = (weights * corners[face][:, :, 2]).sum(1)
    # Sides are drawn as lines only if triangles are large enough.
    edge = (weights * across[face]).min(1) < 0.5
    edge &= across[face].min(1) > 3
    return face, at[:, 1] * SIZE + at[:, 0], depth, edge


def barycentric(corners, face, at):
    """The weights of the corners, and the heights of the triangles over their sides."""
    a, b, c = (corners[:, k, :2] for k in range(3))
    cross = lambda p, q: p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    double = cross(b - a, c - a)
    double = np.where(double == 0, 1e-12, double)
    weights = np.stack([cross(q[face] - at, r[face] - at) / double[face]
                        for q, r in ((b, c), (c, a), (a, b))], 1)
    sides = np.stack([np.linalg.norm(q - r, axis=1) for q, r in ((b, c), (c, a), (a, b))], 1)
    return weights, np.abs(double)[:, None] / np.maximum(sides, 1e-12)


def write_png(path, image):
    height, width, _ = image.shape
    rows = np.hstack([np.zeros((height, 1), np.uint8), image.reshape(height, -1)])
    chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data
                                + struct.pack(">I", zlib.crc32(kind + data)))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
                     + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b""))
