"""Conversions have the bytes and the figures of the program."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import pytest
from conftest import FIXTURES

import scan2step

CASES: List[Any] = [
    ("relief.ply", {"tolerance": 0.5}),
    ("relief.ply", {"units": "in", "keep_fills": True, "name": "a part"}),
    ("relief.ply", {"net": (12, 9), "fit": "global", "outline": "sides", "smooth": 6.0}),
    ("relief.xyz", {"shape": "face", "tolerance": 0.6}),
    ("rolled_sheet.obj", {"map": "mean-value", "boundary_corners": "none"}),
    ("ring.obj", {}),
    ("ring.obj", {"shape": "shell", "face_count": 30}),
]


def arguments(options: Dict[str, Any]) -> List[str]:
    """The same options on the command line."""
    told = {"face_count": "faces"}
    words: List[str] = []
    for key, value in options.items():
        if key == "name":
            continue
        words.append("--" + told.get(key, key).replace("_", "-"))
        if key == "net":
            words.append("x".join(map(str, value)))
        elif value is not True:
            words.append(str(value))
    return words


@pytest.mark.parametrize(("scan", "options"), CASES)
def test_the_bytes_are_those_of_the_program(
    program: str, tmp_path: Path, scan: str, options: Dict[str, Any]
) -> None:
    made = scan2step.convert(FIXTURES / scan, **options)
    # The program names a part by its file.
    file = FIXTURES / scan
    if "name" in options:
        file = tmp_path / f"{options['name']}{file.suffix}"
        file.write_bytes((FIXTURES / scan).read_bytes())
    step, iges, report = (tmp_path / f"part.{kind}" for kind in ("step", "igs", "json"))
    run = [program, "convert", str(file), str(step), str(iges), "--report", str(report), "--quiet"]
    subprocess.run(run + arguments(options), check=True)
    assert made.step() == step.read_bytes()
    assert made.iges(file_name="part.igs") == iges.read_bytes()
    told, own = json.loads(report.read_text()), made.report
    # In Python the report is made before anyone asks for an IGES file.
    told["hints"] = [hint for hint in told["hints"] if not hint.startswith("the IGES file ")]
    for key in ("deviation", "fit", "tolerance_mm", "noise_mm", "shape", "hints", "fill"):
        assert own[key] == told[key], key


def test_threads_do_not_change_a_byte(ring: str) -> None:
    files = [scan2step.convert(ring, threads=n).step() for n in (1, 2, 4)]
    assert files[0] == files[1] == files[2]


@pytest.mark.parametrize("scan", ["relief.ply", "relief.xyz", "ring.obj"])
def test_deviations_are_those_of_the_report(scan: str) -> None:
    made = scan2step.convert(FIXTURES / scan)
    deviations = made.deviations
    vertices = scan2step.read(FIXTURES / scan).vertices
    assert deviations.shape == (len(vertices),)
    known = ~np.isnan(deviations)
    assert known.mean() > 0.99
    told = made.report["deviation"]
    assert np.sqrt(np.mean(deviations[known] ** 2)) == pytest.approx(told["rms_mm"], rel=1e-9)
    assert np.abs(deviations[known]).max() == pytest.approx(told["max_mm"], rel=1e-12)
    distances = made.distance(vertices[known][::10])
    np.testing.assert_allclose(distances, np.abs(deviations[known][::10]), atol=1e-9)
    assert (deviations[known] > 0).any() and (deviations[known] < 0).any()


def test_a_solid_has_a_volume_and_faces(ring: str) -> None:
    made = scan2step.convert(ring)
    assert made.kind == "solid" and made.volume is not None
    assert len(made.faces) == made.report["shape"]["faces"] > 4
    # The same by the divergence theorem, with the middles of a fine net of parameters.
    volume = 0.0
    steps = (np.arange(60) + 0.5) / 60
    for face in made.faces:
        low, high = face.knots_u[0], face.knots_u[-1]
        uv = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * (high - low) + low
        h = 1e-4
        su = (face.points(np.clip(uv + [h, 0], low, high)) - face.points(uv - [h, 0])) / (2 * h)
        sv = (face.points(np.clip(uv + [0, h], low, high)) - face.points(uv - [0, h])) / (2 * h)
        cross = np.cross(su, sv)
        np.testing.assert_allclose(
            face.normals(uv), cross / np.linalg.norm(cross, axis=1, keepdims=True), atol=1e-3
        )
        volume += np.einsum("ij,ij", face.points(uv), cross) / 3 * ((high - low) / 60) ** 2
    assert volume == pytest.approx(made.volume, rel=1e-3)


def test_inspect_and_check_are_those_of_the_program(program: str, relief: str) -> None:
    run = subprocess.run([program, "inspect", relief, "--json"], check=True, capture_output=True)
    assert scan2step.inspect(relief) == json.loads(run.stdout)
    made = scan2step.convert(relief, tolerance=0.5)
    found = scan2step.check(made, relief, tolerance=0.8)
    assert found["tolerance_met"] is True
    assert found["scan_to_face"]["rms_mm"] == pytest.approx(made.rms, rel=1e-3)
    assert scan2step.check(made.step(), relief, tolerance=0.01)["tolerance_met"] is False


def test_the_version_is_that_of_the_program(program: str) -> None:
    run = subprocess.run([program, "--version"], check=True, capture_output=True, text=True)
    assert run.stdout.split() == ["scan2step", scan2step.__version__]
