"""Files are whole or not there, and errors name them."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import FIXTURES

import scan2step
from scan2step import dask


def test_all_files_are_written_or_none(relief: str, tmp_path: Path) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    names = ["a.step", "a.stp", "a.igs", "a.html", "a.png", "a.json"]
    made.write(*(tmp_path / name for name in names))
    assert sorted(os.listdir(tmp_path)) == sorted(names)
    assert (tmp_path / "a.step").read_bytes() == made.step()
    assert json.loads((tmp_path / "a.json").read_text()) == made.report
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(scan2step.FileError) as caught:
        made.write(empty / "b.step", empty / "missing" / "b.igs")
    assert "missing" in str(caught.value) and caught.value.help
    with pytest.raises(scan2step.OptionError):
        made.write(empty / "b.step", empty / "b.dxf")
    assert os.listdir(empty) == []


def test_errors_say_what_to_do(relief: str, tmp_path: Path) -> None:
    with pytest.raises(scan2step.FileError) as missing:
        scan2step.convert(tmp_path / "no.ply")
    assert missing.value.path == str(tmp_path / "no.ply") and missing.value.help
    broken = tmp_path / "broken.ply"
    broken.write_bytes((FIXTURES / "relief.ply").read_bytes()[:3000])
    with pytest.raises(scan2step.FileError) as cut:
        scan2step.read(broken)
    assert "broken.ply" in str(cut.value)
    for option, value in [("tolerance", -1.0), ("outliers", 1.0), ("net", (2, 2)), ("fit", "best")]:
        with pytest.raises(scan2step.OptionError) as wrong:
            scan2step.convert(relief, **{option: value})  # type: ignore[arg-type]
        assert wrong.value.option == option and isinstance(wrong.value, ValueError)
    with pytest.raises(TypeError):
        scan2step.convert(relief, tolerance="small")  # type: ignore[arg-type]
    with pytest.raises(scan2step.MemoryBoundError):
        scan2step.convert(relief, max_memory=1000)
    with pytest.raises(scan2step.TopologyError):
        scan2step.convert(FIXTURES / "ring.obj", shape="face")


def test_conversions_are_not_pickled(relief: str) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    for thing in (made, scan2step.read(relief)):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(thing)


def test_a_time_stamp_comes_from_the_environment(relief: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    assert b"2001-09-09T01:46:40" in made.step()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(scan2step.OptionError):
        made.step()


def test_a_notebook_shows_a_picture(relief: str) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    shown = made._repr_html_()
    assert shown.startswith("<img alt=") and len(shown) < 1_400_000
    assert "relief.ply" in made.html()


def test_the_module_runs_as_a_program(relief: str, tmp_path: Path) -> None:
    out = tmp_path / "part.step"
    run = [sys.executable, "-m", "scan2step"]
    convert = run + ["convert", relief, str(out), "--tolerance", "0.5", "--keep-fills"]
    done = subprocess.run(convert, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "a face of 1 face" in done.stdout
    assert out.read_bytes() == scan2step.convert(relief, tolerance=0.5, keep_fills=True).step()
    found = subprocess.run(run + ["inspect", relief], capture_output=True, text=True)
    assert json.loads(found.stdout) == scan2step.inspect(relief)
    missed = subprocess.run(run + ["check", str(out), relief, "--tolerance", "0.01"], capture_output=True)
    assert missed.returncode == 3
    failed = subprocess.run(run + ["convert", "no.ply", str(out)], capture_output=True, text=True)
    assert failed.returncode == 1 and "help:" in failed.stderr


def test_a_task_of_an_engine_is_done_once(relief: str, tmp_path: Path) -> None:
    out = tmp_path / "cad" / "relief.step"
    row = dask.convert_file(relief, out, tolerance=0.5)
    assert row["status"] == "ok" and row["shape"] == "face"
    assert out.read_bytes() == scan2step.convert(relief, tolerance=0.5).step()
    before = out.stat().st_mtime_ns
    assert dask.convert_file(relief, out, tolerance=0.5) == row
    assert out.stat().st_mtime_ns == before
    other = dask.convert_file(relief, out, tolerance=0.4)
    assert other["key"] != row["key"]
    out.unlink()
    assert dask.convert_file(relief, out, tolerance=0.4) == other and out.exists()
    failed = dask.convert_file(tmp_path / "no.ply", tmp_path / "no.step")
    assert failed["status"] == "failed" and failed["help"]


def test_what_is_no_ordinary_file_is_refused_and_links_stay(relief: str, tmp_path: Path) -> None:
    made = scan2step.convert(relief, tolerance=0.5)
    (tmp_path / "old.step").write_bytes(b"old")
    (tmp_path / "folder.step").mkdir()
    with pytest.raises(scan2step.FileError):
        made.write(tmp_path / "old.step", tmp_path / "folder.step")
    assert (tmp_path / "old.step").read_bytes() == b"old"
    (tmp_path / "link.step").symlink_to(tmp_path / "old.step")
    made.write(tmp_path / "link.step")
    assert (tmp_path / "link.step").is_symlink()
    assert (tmp_path / "old.step").read_bytes() == made.step()
    with pytest.raises(ValueError):
        made.step(colour=(256, 0, 0))


def test_values_beyond_all_bounds_name_their_option(relief: str) -> None:
    for option in ("face_count", "depth", "max_points", "scan_number", "max_memory", "threads", "max_net"):
        with pytest.raises(scan2step.OptionError) as caught:
            scan2step.convert(relief, **{option: -1})  # type: ignore[arg-type]
        assert caught.value.option == option and option in str(caught.value)
    with pytest.raises(ValueError, match="outer"):
        scan2step.convert(relief, outer="near")  # type: ignore[arg-type]
    with pytest.raises(scan2step.OptionError):
        scan2step.convert(relief, keep_fills=True, fill_only_holes_below=5.0)
    with pytest.raises(TypeError):
        scan2step.convert(relief, [[0, 1, 2]])
    for option, value in [("tolerance", float("nan")), ("tolerance", 0.0), ("outliers", -0.1)]:
        with pytest.raises(scan2step.OptionError):
            scan2step.check(b"", relief, **{option: value})  # type: ignore[arg-type]
    with pytest.raises(scan2step.FileError, match="the bytes of the CAD file"):
        scan2step.check(b"", relief)


def test_rows_of_tasks_know_arrays_and_names(relief: str, tmp_path: Path) -> None:
    out = tmp_path / "part.step"
    first, second = np.zeros((4, 3)), np.ones((4, 3))
    keys = [dask._key(relief, {"corners": corners}) for corners in (first, second, first.copy())]
    assert keys[0] == keys[2] != keys[1]
    row = dask.convert_file(relief, out, tolerance=0.5)
    (tmp_path / "part.step.row.json").write_text("[]")
    assert dask.convert_file(relief, out, tolerance=0.5) == row
