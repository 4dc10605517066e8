"""Parts of CAD programs have exact faces."""

from collections import Counter
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import scan2step

BRACKET = Path(__file__).parents[2] / "fixtures/bracket.stl"


@pytest.fixture(scope="module")
def bracket() -> scan2step.Conversion:
    return scan2step.convert(BRACKET)


def test_faces_have_the_surfaces_of_the_part(bracket: scan2step.Conversion) -> None:
    kinds = Counter(face.surface.kind for face in bracket.faces)
    assert kinds == {"plane": 7, "cylinder": 5, "cone": 2, "torus": 1}
    cone = next(face.surface for face in bracket.faces if face.surface.kind == "cone")
    assert cone.half_angle == pytest.approx(45, abs=1e-4)
    torus = next(face.surface for face in bracket.faces if face.surface.kind == "torus")
    assert torus.tube_radius == pytest.approx(1.5, abs=1e-5)
    assert np.allclose(np.abs(axis(torus)), [1, 0, 0])


def test_cylinders_are_bores_and_fillets(bracket: scan2step.Conversion) -> None:
    rows = [(row.kind, round(row.radius, 4)) for row in bracket.cylinders()]
    assert rows == [("round", 20.0), ("bore", 9.0), ("fillet", 8.0), ("bore", 2.75), ("bore", 2.75)]


def test_cylinders_tell_their_faces(bracket: scan2step.Conversion) -> None:
    for row in bracket.cylinders():
        surfaces = [bracket.faces[face].surface for face in row.faces]
        assert surfaces and all(surface.radius == row.radius for surface in surfaces)


def test_relations_are_groups_of_cylinders(bracket: scan2step.Conversion) -> None:
    found = {(relation.kind, relation.cylinders, relation.to) for relation in bracket.relations()}
    assert found == {
        ("equal radius", (3, 4), ()),
        ("coaxial", (0, 1), ()),
        ("parallel", (3, 4), ()),
        ("perpendicular", (0, 1), (2, 3, 4)),
        ("perpendicular", (3, 4), (2,)),
    }


def test_inspect_tells_of_exact_faces() -> None:
    found = scan2step.inspect(BRACKET)["exact"]
    assert found["radii_mm"] == pytest.approx([20, 9, 8, 2.75, 2.75])
    assert (found["surfaces"]["plane"], found["facets"]) == (7, 0)


def test_only_splines_have_control_points(bracket: scan2step.Conversion) -> None:
    face = bracket.faces[0]
    with pytest.raises(ValueError, match="no control points"):
        face.control_points
    assert repr(face) == f"<scan2step.Face {face.surface.kind}>"
    splined = scan2step.convert(BRACKET, surfaces="spline", face_count=60)
    assert {face.surface.kind for face in splined.faces} == {"spline"}
    assert splined.cylinders() == [] and splined.relations() == []


def test_edges_are_lines_and_circles_where_the_part_has_them(bracket: scan2step.Conversion) -> None:
    for face in bracket.faces:
        for loop in face.loops:
            for arc in loop.arcs:
                assert np.allclose(face.points(start(arc.pcurve)[None]), start(arc.edge), atol=1e-5)
    circles = [
        np.linalg.norm(arc.edge.axes[0])
        for face in bracket.faces
        for loop in face.loops
        for arc in loop.arcs
        if isinstance(arc.edge, scan2step.Ellipse)
    ]
    # The seam edge of the torus is the smallest circle.
    assert min(circles) == pytest.approx(1.5, abs=1e-5)


def axis(surface: scan2step.Surface) -> tuple[float, float, float]:
    """The axis of a surface, or a plane's normal."""
    assert surface.axis is not None
    return surface.axis


def start(curve: scan2step.Curve | scan2step.Ellipse) -> npt.NDArray[np.float64]:
    """The first point of a curve."""
    if isinstance(curve, scan2step.Ellipse):
        t = curve.range[0]
        return np.asarray(curve.centre + np.cos(t) * curve.axes[0] + np.sin(t) * curve.axes[1])
    return np.asarray(curve.control_points[0])


def test_a_normal_points_out_of_the_part(bracket: scan2step.Conversion) -> None:
    top = max((face for face in bracket.faces if face.surface.kind == "plane"), key=lambda f: abs(axis(f.surface)[2]))
    assert np.allclose(np.abs(top.normals(np.zeros((1, 2)))), [[0, 0, 1]], atol=1e-6)


def test_distances_are_those_from_the_exact_faces(bracket: scan2step.Conversion) -> None:
    # A point in the middle of the bore is as far from it as its radius.
    assert bracket.distance([[2.25, 20, 35]])[0] == pytest.approx(9, abs=1e-4)
    assert np.nanmax(np.abs(bracket.deviations)) < 1e-5


def test_an_aligned_part_is_where_its_matrix_says(bracket: scan2step.Conversion) -> None:
    assert bracket.placement is None
    made = scan2step.convert(BRACKET, align=True)
    assert made.placement is not None
    matrix = np.array(made.placement)
    assert np.allclose(matrix[:, :3] @ matrix[:, :3].T, np.eye(3))
    there = scan2step.check(made, BRACKET, placement=made.placement)
    assert there["scan_to_face"]["max_mm"] < 1e-4
