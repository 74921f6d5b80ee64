"""Shared by all tests: the built module, the frame database, a seed for each random test, and what the workers of
`make test` share."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import groups
import hypothesis
import numpy as np
import pytest
import simulation

try:
    import comanip._core  # noqa: F401
except ImportError as error:
    pytest.exit(f"comanip is not built ({error}): run `make build` first", returncode=2)

REPOSITORY = Path(__file__).resolve().parents[1]
hypothesis.settings.register_profile("suite", deadline=None, derandomize=True)  # however busy the machine is
hypothesis.settings.load_profile("suite")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # behind a shell's `&`: what tests start would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20100727)


@pytest.fixture(scope="session")
def dbc():
    import cantools

    return cantools.database.load_file(REPOSITORY / "host_tools" / "comanip" / "comanip.dbc")


@pytest.fixture(scope="session", autouse=True)
def _shared_runs(tmp_path_factory):
    """One folder for all workers: each has a folder of its own beside it."""
    own = tmp_path_factory.getbasetemp()
    simulation.SHARED.folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "shared-runs"


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the marks
def pytest_collection_modifyitems(config, items):
    if not hasattr(config, "workerinput"):
        return
    for item in items:
        item.add_marker(pytest.mark.xdist_group(groups.group_of(item.nodeid)[1]))
    items.sort(key=lambda item: groups.group_of(item.nodeid))


def pytest_report_header(config):
    """Under `make test`."""
    if not getattr(config.option, "numprocesses", None):
        return []
    lines = [f"  {group.name}: {group.reason}" for group in groups.GROUPS]
    return ["on one worker each, one after the other, in this order; all others by their files:", *lines]
