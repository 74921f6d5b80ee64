"""Provides what all tests share: the frame database, a seeded random generator, and the folder in which the workers of
`make test` share files. Ends the session if the compiled module is missing."""

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
hypothesis.settings.register_profile("suite", deadline=None, derandomize=True)  # independent of the machine's load
hypothesis.settings.load_profile("suite")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a background job; children would inherit this
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
    """Sets the folder that all workers share. If there are workers, this folder lies beside their own folders."""
    own = tmp_path_factory.getbasetemp()
    simulation.SHARED.folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "shared-runs"


def pytest_collection_modifyitems(config, items):
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: groups.position_of(item.nodeid))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Schedules tests by the groups in groups.py. pytest-xdist's own `--dist loadgroup` cannot be used, because its
    marks have no effect in pytest 9.2."""
    from xdist.scheduler import LoadScopeScheduling

    class ByGroup(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return groups.group_of(nodeid)

    return ByGroup(config, log)


def pytest_report_header(config):
    return groups.header() if getattr(config.option, "numprocesses", None) else []
