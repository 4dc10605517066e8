"""Arrays of any kind come in, and views go out."""

from __future__ import annotations

import gc
import random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import scan2step


def sheet(n: int = 20) -> Any:
    x, y = np.meshgrid(np.arange(float(n)), np.arange(float(n)))
    points = np.stack([x, y, 0.02 * x**2], axis=-1).reshape(-1, 3)
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = (at[i : n - 1 + i, j : n - 1 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0)))
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def test_types_and_strides_do_not_matter() -> None:
    points, faces = sheet()
    made = scan2step.convert(points, faces, tolerance=0.05, name="part").step()
    wide = np.zeros((len(points), 6))
    wide[:, ::2] = points
    for vertices, triangles in [
        (np.asfortranarray(points), faces.astype(np.int32)),
        (wide[:, ::2], faces.astype(np.uint64)),
        (points.tolist(), faces.tolist()),
    ]:
        assert scan2step.convert(vertices, triangles, tolerance=0.05, name="part").step() == made


def test_meshes_of_other_packages_are_taken_as_they_are() -> None:
    points, faces = sheet()
    made = scan2step.convert(points, faces, tolerance=0.05, name="part").step()
    trimesh = pytest.importorskip("trimesh")
    vectors = [SimpleNamespace(x=x, y=y, z=z) for x, y, z in points]
    for mesh in [
        (points, faces),
        trimesh.Trimesh(points, faces, process=False),
        SimpleNamespace(vertices=points, triangles=faces),  # Open3D
        SimpleNamespace(points=points, regular_faces=faces),  # PyVista
        SimpleNamespace(Topology=(vectors, [tuple(face) for face in faces])),  # FreeCAD
    ]:
        assert scan2step.convert(mesh, tolerance=0.05, name="part").step() == made


def test_points_without_faces_are_a_cloud() -> None:
    points, _ = sheet(40)
    made = scan2step.convert(points, tolerance=0.2)
    assert made.kind == "face" and made.report["input"]["points"] == len(points)


def test_views_do_not_copy_and_stay_valid(relief: str) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    face = made.faces[0]
    net, knots = face.control_points, face.knots_u
    assert not net.flags.owndata and not net.flags.writeable and not knots.flags.writeable
    assert np.shares_memory(net, made.faces[0].control_points)
    kept = net.copy()
    del made, face
    gc.collect()
    _ = [np.ones(net.size) for _ in range(50)]
    np.testing.assert_array_equal(net, kept)
    with pytest.raises(ValueError):
        net[0, 0, 0] = 1.0


def test_loops_close_in_the_parameter_plane_and_in_space(relief: str) -> None:
    face = scan2step.convert(relief, tolerance=0.5).faces[0]
    assert [loop.hole for loop in face.loops] == [False, True, True]
    for loop in face.loops:
        for curves in ([arc.pcurve for arc in loop.arcs], [arc.edge for arc in loop.arcs]):
            runs = zip(curves, (arc.forward for arc in loop.arcs))
            ends = [splined(c).control_points[:: 1 if forward else -1][[0, -1]] for c, forward in runs]
            for (_, end), (start, _) in zip(ends, ends[1:] + ends[:1]):
                np.testing.assert_allclose(end, start, atol=1e-9)


def test_edges_lie_on_the_surface(relief: str) -> None:
    face = scan2step.convert(relief, tolerance=0.5).faces[0]
    for arc in (arc for loop in face.loops for arc in loop.arcs):
        pcurve, edge = splined(arc.pcurve), splined(arc.edge)
        np.testing.assert_allclose(face.points(pcurve.control_points[[0, -1]]), edge.control_points[[0, -1]], atol=1e-9)
        assert len(edge.knots) == len(edge.control_points) + edge.degree + 1


def splined(curve: scan2step.Curve | scan2step.Ellipse) -> scan2step.Curve:
    """The curve, which is a B-spline."""
    assert isinstance(curve, scan2step.Curve)
    return curve


def test_nonsense_is_refused_in_words() -> None:
    """Whatever arrays come in, what comes out is a conversion or one of three exceptions."""
    rng = random.Random(7)
    points, faces = sheet(8)
    bad_points = [
        points[:, :2],
        points.ravel(),
        points.astype(complex),
        np.full_like(points, np.nan),
        np.where(rng.random() < 0.5, np.inf, points),
        np.zeros((0, 3)),
        points.astype(str),
        [[1, 2], [3]],
        None,
        3,
        object(),
        points * 1e300,
        points.astype(np.float16),
        np.zeros((64, 3)),
    ]
    bad_faces = [
        faces.astype(float),
        faces - 1,
        faces + 1000,
        faces[:, :2],
        faces.ravel(),
        faces.astype(np.int8),
        np.zeros_like(faces),
        [],
        [[0, 1, 2], [3, 4]],
        np.array([[2**40, 0, 1]]),
        "faces",
        {},
    ]
    cases = [(p, faces) for p in bad_points] + [(points, f) for f in bad_faces]
    cases += [(rng.choice(bad_points), rng.choice(bad_faces)) for _ in range(60)]
    cases += [(p, None) for p in bad_points]
    for vertices, triangles in cases:
        try:
            scan2step.convert(vertices, triangles)
        except (scan2step.Scan2StepError, ValueError, TypeError) as error:
            assert not isinstance(error, scan2step.InternalError), error
            assert str(error)


def test_parameter_points_beyond_the_surface_are_refused(relief: str) -> None:
    face = scan2step.convert(relief, tolerance=0.5).faces[0]
    for uv in ([[2.0, 0.5]], [[0.5]], [[float("nan"), 0.5]]):
        with pytest.raises(ValueError):
            face.points(uv)


def test_masks_and_numbers_that_are_none_are_refused(relief: str) -> None:
    points, faces = sheet()
    hidden = np.ma.masked_array(points, mask=points > 5)
    with pytest.raises(ValueError, match="masked"):
        scan2step.convert(hidden, faces)
    made = scan2step.convert(relief, tolerance=0.5)
    with pytest.raises(ValueError, match="not finite"):
        made.distance([[float("nan"), 0.0, 0.0]])


def test_a_sheet_that_is_no_solid_is_refused() -> None:
    points, faces = sheet(8)
    with pytest.raises(scan2step.ScanError):
        scan2step.convert(points, faces, shape="solid")


def test_meshes_that_overlap_become_one_face() -> None:
    points, faces = sheet()
    middle = points[faces].mean(axis=1)[:, 0]
    left, right = faces[middle < 12.0], faces[middle > 7.0]
    vertices = np.concatenate([points, points + 1e-3])
    both = np.concatenate([left, right + len(points)])
    made = scan2step.convert(vertices, both, remesh=True, shape="face", tolerance=0.1)
    assert made.report["options"]["remesh"] is True
    found = scan2step.check(made, vertices, both, remesh=True)
    assert found["scan_to_face"]["max_mm"] < 0.1


def test_parts_are_left_out(relief: str) -> None:
    whole = scan2step.read(relief)
    made = scan2step.convert(whole, box=((-20, -100, -100), (30, 100, 100)), tolerance=0.5)
    kept = ~np.isnan(made.deviations)
    inside = (whole.vertices[:, 0] >= -20) & (whole.vertices[:, 0] <= 30)
    assert kept[inside].mean() > 0.98 and not kept[~inside].any()
