"""Shared by all tests: the built module, the frame database, and a seed for each random test."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

try:
    import comanip._core  # noqa: F401
except ImportError as error:
    pytest.exit(f"comanip is not built ({error}): run `make build` first", returncode=2)

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20100727)


@pytest.fixture(scope="session")
def dbc():
    import cantools

    return cantools.database.load_file(REPOSITORY / "host_tools" / "comanip" / "comanip.dbc")
