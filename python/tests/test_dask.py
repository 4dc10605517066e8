"""A real Dask on one machine, of which a worker is killed. It has a deadline."""

from __future__ import annotations

import subprocess
import sys

import pytest
from conftest import ROOT


def test_nothing_is_lost_if_workers_are_killed() -> None:
    pytest.importorskip("distributed")
    script = ROOT / "benches/engines/run_dask.py"
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr[-3000:]
    assert "25 rows, 24 files" in run.stdout
    assert "a second run converted nothing again" in run.stdout
