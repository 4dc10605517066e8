"""The examples of docs/python.md and of the docstrings run, and the types hold."""

from __future__ import annotations

import doctest
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import List

import pytest
from conftest import FIXTURES, ROOT

import scan2step
from scan2step import _functions

GUIDE = ROOT / "docs/python.md"


def examples() -> List[str]:
    return re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)


def test_there_are_ten_examples() -> None:
    assert len(examples()) >= 10


@pytest.mark.parametrize("number", range(len(examples())))
def test_an_example_runs(number: int, tmp_path: Path) -> None:
    for package in ("build123d", "matplotlib", "distributed", "trimesh"):
        pytest.importorskip(package)
    for name in ("relief.ply", "relief.xyz", "ring.obj", "bracket.stl", "joint.glb"):
        shutil.copy(FIXTURES / name, tmp_path)
    (tmp_path / "scans").mkdir()
    for name in ("relief.ply", "ring.obj"):
        shutil.copy(FIXTURES / name, tmp_path / "scans")
    script = tmp_path / "example.py"
    # Processes that are spawned import the script again.
    lines = examples()[number].splitlines()
    script.write_text("def main():\n    " + "\n    ".join(lines) + "\n\nif __name__ == '__main__':\n    main()\n")
    run = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr


def test_the_examples_of_docstrings_run() -> None:
    for module in (scan2step, _functions):
        assert doctest.testmod(module).failed == 0


def test_the_types_hold() -> None:
    pytest.importorskip("mypy")
    strict = [sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null"]
    untyped = ["--disable-error-code=import-untyped", "--disable-error-code=import-not-found"]
    own = subprocess.run(strict + untyped + ["-p", "scan2step"], capture_output=True, text=True)
    assert own.returncode == 0, own.stdout
    here = Path(__file__).parent
    files = sorted(map(str, here.glob("*.py")))
    tests = subprocess.run(strict + untyped + files, capture_output=True, text=True, cwd=here)
    assert tests.returncode == 0, tests.stdout
    stubs = [sys.executable, "-m", "mypy.stubtest", "scan2step._scan2step", "--ignore-disjoint-bases"]
    found = subprocess.run(stubs, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout
