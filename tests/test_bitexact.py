"""Checks that the same input produces the same bytes on the host and on the targets, by a short run of `make bitexact`,
and that `make bitexact` detects a build with different arithmetic."""

from __future__ import annotations

import sys

import pytest
from images import EMULATED, make
from simulation import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "bitexact"))
import bitexact  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bitexact")


def test_all_builds_send_the_same_bytes(folder):
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    results = bitexact.run(folder, smoke=True)
    assert len(results) == len(bitexact.HOSTS) + len(EMULATED)
    done = [result for result in results if not result.skipped]
    assert {result.ticks for result in done} == {done[0].ticks} and done[0].ticks > 6000
    assert [result for result in done if result.differs_at_tick is not None] == []


def test_different_arithmetic_is_detected(folder):
    """A build whose compiler may reorder sums produces different bytes."""
    if not (folder / "input.bin").exists():
        bitexact.make_input(folder, smoke=True)
    reference = bitexact.host_output(folder, "gcc", "-O2")
    program = folder / "other"
    program.mkdir(exist_ok=True)
    bitexact.compile_host(program / "runner", "gcc", "-O2", "-ffast-math")
    other = bitexact.compared("other", bitexact.run_in(folder, "other", [str(program / "runner")]), reference)
    assert other.differs_at_tick is not None
