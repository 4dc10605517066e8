"""What the tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIXTURES = ROOT / "fixtures"


@pytest.fixture(scope="session")
def program() -> str:
    """The program scan2step, which tests/run has built."""
    path = os.environ.get("SCAN2STEP_PROGRAM", str(ROOT / "target/debug/scan2step"))
    assert os.path.isfile(path), f"{path} is absent; tests/run builds it"
    return path


@pytest.fixture
def relief() -> str:
    return str(FIXTURES / "relief.ply")


@pytest.fixture
def ring() -> str:
    return str(FIXTURES / "ring.obj")
