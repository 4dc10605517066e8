"""Files are whole or not there, and errors name them."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

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
