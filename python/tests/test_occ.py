"""Shapes of build123d and CadQuery: valid, with the areas and volumes of the conversion."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from conftest import FIXTURES, ROOT

import scan2step



def area(shape: Any) -> float:
    """The area of an OpenCASCADE shape to ten digits. Its usual one has five."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, found, 1e-10)
    return float(found.Mass())


FACES = ["relief.ply", "relief.xyz", "rolled_sheet.obj"]


@pytest.mark.parametrize("scan", FACES)
def test_a_face_of_build123d_is_thickened(scan: str) -> None:
    build123d = pytest.importorskip("build123d")
    made = scan2step.convert(FIXTURES / scan, shape="face")
    face = made.to_build123d()
    assert isinstance(face, build123d.Face) and face.is_valid
    assert area(face.wrapped) == pytest.approx(made.area, rel=1e-8)
    holes = made.report["fill"]["holes"]
    assert len(face.inner_wires()) >= sum(hole["trimmed"] for hole in holes)
    solid = build123d.Solid.thicken(face, 2.0)
    assert solid.is_valid and solid.volume == pytest.approx(2.0 * made.area, rel=0.1)


def test_a_solid_of_build123d_is_cut(ring: str) -> None:
    build123d = pytest.importorskip("build123d")
    made = scan2step.convert(ring)
    solid = made.to_build123d()
    assert isinstance(solid, build123d.Solid) and solid.is_valid
    assert solid.volume == pytest.approx(made.volume, rel=1e-5)
    half = solid & build123d.Pos(0, 0, 100) * build123d.Box(300, 300, 200)
    assert 0.2 * solid.volume < half.volume < 0.8 * solid.volume


def test_shapes_of_cadquery(relief: str, ring: str) -> None:
    cadquery = pytest.importorskip("cadquery")
    made = scan2step.convert(relief, tolerance=0.5)
    face = made.to_cadquery()
    assert isinstance(face, cadquery.Face) and face.isValid()
    assert area(face.wrapped) == pytest.approx(made.area, rel=1e-8)
    assert len(face.innerWires()) == 2
    assert face.thicken(2.0).isValid()
    whole = scan2step.convert(ring)
    solid = whole.to_cadquery()
    assert isinstance(solid, cadquery.Solid) and solid.isValid()
    assert solid.Volume() == pytest.approx(whole.volume, rel=1e-5)


def test_the_example_of_cadquery_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cadquery")
    (example,) = re.findall(r"```py\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL)
    shutil.copy(FIXTURES / "relief.ply", tmp_path)
    monkeypatch.chdir(tmp_path)
    exec(example, {})
    assert (tmp_path / "part.step").stat().st_size > 10_000
