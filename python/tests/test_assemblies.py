"""Files with several parts: each part once, in its places, with names and colours."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

import numpy as np
import pytest
from conftest import FIXTURES

import scan2step


@pytest.fixture(scope="module", params=["joint.glb", "joint.3mf"])
def joint(request: pytest.FixtureRequest) -> scan2step.Assembly:
    made = scan2step.convert(FIXTURES / request.param, up="z")
    assert isinstance(made, scan2step.Assembly)
    return made


def test_parts_are_there_once(joint: scan2step.Assembly) -> None:
    assert joint.kind == "assembly"
    rows = [(part.name, part.colour, len(part.places)) for part in joint.parts]
    assert rows == [("flange", (70, 110, 160), 2), ("bolt", (200, 160, 60), 4), ("nut", (90, 90, 96), 4)]
    assert all(part.made.kind == "solid" for part in joint.parts)
    volumes = [part.made.volume or 0.0 for part in joint.parts]
    assert joint.volume == pytest.approx(np.dot(volumes, [2, 4, 4]))


def test_places_are_matrices(joint: scan2step.Assembly) -> None:
    lower, upper = joint.parts[0].places
    # Components of 3MF have no names.
    assert lower.path in (("pipe joint", "lower flange"), ("pipe joint", "flange"))
    assert np.allclose(lower.matrix, np.diag([1.0, -1.0, -1.0, 1.0]), atol=1e-7)
    assert np.allclose(upper.matrix, np.eye(4), atol=1e-7)
    shifts = sorted(tuple(np.round(place.matrix[:3, 3]).astype(int)) for place in joint.parts[2].places)
    assert shifts == [(x, y, -13) for x in (-22, 22) for y in (-22, 22)]


def test_the_tree_is_that_of_the_file(joint: scan2step.Assembly) -> None:
    tree = joint.tree
    assert [node.name for node in tree if node.parent is None] == ["pipe joint"]
    groups = [k for k, node in enumerate(tree) if node.part is None and node.parent is not None]
    inside = [[node.name for node in tree if node.parent == group] for group in groups]
    assert inside == [["bolt", "nut"]] * 4


def test_distances_are_those_of_the_nearest_place(joint: scan2step.Assembly) -> None:
    # Above the head of a bolt, and beside the lower flange, whose nearest place is its upper edge.
    found = joint.distance([[22.0, 22.0, 15.0], [40.0, 0.0, -12.0]])
    assert found == pytest.approx([3.0, 116.0**0.5], abs=1e-4)
    with pytest.raises(ValueError, match="each part"):
        joint.deviations


def test_files_are_written(joint: scan2step.Assembly, tmp_path: Path) -> None:
    names = ["joint.step", "joint.igs", "joint.html", "joint.png", "joint.json"]
    joint.write(*(tmp_path / name for name in names))
    assert joint.step().count(b"MANIFOLD_SOLID_BREP(") == 3
    assert joint.step().count(b"NEXT_ASSEMBLY_USAGE_OCCURRENCE(") == 8
    assert (tmp_path / "joint.png").read_bytes().startswith(b"\x89PNG")
    assert "flange" in (tmp_path / "joint.html").read_text()
    assert joint.report["options"]["up"] == "z"


def test_parts_can_be_merged() -> None:
    made = scan2step.convert(FIXTURES / "joint.glb", parts="merge")
    assert not isinstance(made, scan2step.Assembly)
    with pytest.raises(scan2step.OptionError):
        scan2step.convert(FIXTURES / "joint.glb", parts="some")
    with pytest.raises(scan2step.OptionError):
        scan2step.convert(FIXTURES / "joint.glb", parts="keep", component=0)


def leaves(node: Any, found: Dict[str, int]) -> Dict[str, int]:
    """The names of what has no children, and how often each occurs."""
    if node.children:
        for child in node.children:
            leaves(child, found)
    else:
        found[node.label] = found.get(node.label, 0) + 1
    return found


def test_an_assembly_of_build123d(joint: scan2step.Assembly) -> None:
    pytest.importorskip("build123d")
    whole = joint.to_build123d()
    assert whole.label == "pipe joint" and len(whole.children) == 6
    found = leaves(whole, {})
    assert (found["bolt"], found["nut"], sum(found.values())) == (4, 4, 10)
    assert sum(solid.volume for solid in whole.solids()) == pytest.approx(joint.volume, rel=1e-6)
    red, green, blue, _ = tuple(whole.children[0].color)
    assert (red, green, blue) == pytest.approx((70 / 255, 110 / 255, 160 / 255), abs=0.01)


def test_an_assembly_of_cadquery(joint: scan2step.Assembly) -> None:
    pytest.importorskip("cadquery")
    whole = joint.to_cadquery()
    assert whole.name == "pipe joint" and len(whole.children) == 6
    assert whole.children[0].name in ("lower flange", "flange")
    assert [child.name for child in whole.children[2].children] == ["bolt", "nut"]
    assert whole.toCompound().Volume() == pytest.approx(joint.volume, rel=1e-6)
    assert whole.children[0].color.toTuple()[:3] == pytest.approx((70 / 255, 110 / 255, 160 / 255), abs=0.01)
