"""Checks that `make test-sanitised` uses the sanitised core, and that the run fails if a sanitiser finds an error."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from comanip import _core

sys.path.insert(0, str(Path(__file__).parent))
import core_users  # noqa: E402
import run  # noqa: E402

FOLDER, RUNTIME = Path(os.environ["COMANIP_SANITISED"]), os.environ["COMANIP_SANITISER_RUNTIME"]
HEAD = "import subprocess, sys, pytest\nfrom comanip._core import ffi, lib\n"
# Invalid calls into the core, and the sanitiser's report that each must trigger.
FAULTS = {
    "read past the end": (
        """
        one, two = ffi.new("dual_quaternion_t[1]"), ffi.new("dual_quaternion_t[2]")
        lib.batch_multiply(2, one, one, two)
        """,
        "AddressSanitizer: heap-buffer-overflow",
    ),
    "index": (
        """
        controller, inbox, outbox = ffi.new("controller_t *"), ffi.new("controller_inbox_t *"), ffi.new("outbox_t *")
        lib.controller_init(controller, ffi.addressof(lib.arm_ik_hoap3_right), lib.CAN_PROFILE_FD)
        inbox.count = len(inbox.frame) + 2
        lib.outbox_step(outbox, controller, 1000, inbox)
        """,
        r"runtime error: index \d+ out of bounds for type 'can_frame_t",
    ),
    "bool": (
        """
        message = ffi.new("hand_pose_t *")
        ffi.buffer(ffi.addressof(message, "valid"))[0:1] = bytes([2])
        lib.hand_pose_pack(message, ffi.new("can_frame_t *"))
        """,
        "runtime error: load of value 2, which is not a valid value for type '_Bool'",
    ),
    "signed overflow": (
        """
        lib.rotation_encode(ffi.new("int32_t[4]", 4 * [-(2**31)]), ffi.new("rotation_code_t *"))
        """,
        "runtime error: signed integer overflow",
    ),
    "float to integer": (
        """
        lib.float_nearest(1e30)
        """,
        r"runtime error: 1e\+30 is outside the range of representable values of type 'int'",
    ),
}


def undefined_symbols(library: Path) -> str:
    return subprocess.run(["nm", "-D", "-u", library], capture_output=True, text=True, check=True).stdout


def test_the_core_is_the_sanitised_one():
    assert Path(_core.__file__) == FOLDER / "_core.abi3.so"


@pytest.mark.parametrize("library", ["_core.abi3.so", "rest/loop.so"])
def test_both_sanitisers_are_in(library):
    symbols = undefined_symbols(FOLDER / library)
    assert "__asan_report_load" in symbols
    assert "__ubsan_handle_out_of_bounds_abort" in symbols and "__ubsan_handle_float_cast_overflow_abort" in symbols


@pytest.mark.parametrize("environment", [None, {"PATH": os.environ["PATH"]}], ids=["inherited", "chosen by the test"])
def test_a_child_process_has_the_sanitised_core(environment):
    code = "from comanip import _core; print(_core.__file__)"
    child = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert Path(child.stdout.strip()) == FOLDER / "_core.abi3.so"


def test_tests_of_the_core_are_found_by_their_imports():
    names = {file.name for file in core_users.test_files()}
    # These tests call controller_step() in four ways: on the test bench, in the replay, in the loop of `make following`
    # and in the C loop of tests/rest.
    assert names >= {"test_controller.py", "test_replay.py", "test_following.py", "test_rest.py"}
    direct = {file.name for file in core_users.TESTS.glob("test_*.py") if "\nfrom comanip._core " in file.read_text()}
    assert len(direct) > 20 and names >= direct - core_users.OTHER_PROCESSES
    assert not names & {"test_hub.py", "test_package.py", *core_users.OTHER_PROCESSES}


@pytest.fixture
def seeded_run(tmp_path, capfd):
    """Returns a function that runs the given source code of a test as `make test-sanitised` does, and returns the
    exit status and the output."""

    def run_it(text: str) -> tuple[int, str]:
        file = tmp_path / "test_seeded.py"
        file.write_text(text)
        options = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist"]
        status = run.run([file], options, FOLDER, RUNTIME, tmp_path / "reports")
        output = capfd.readouterr()
        return status, output.out + output.err

    return run_it


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_the_core_fails_the_run(seeded_run, fault):
    code, expected = FAULTS[fault]
    status, said = seeded_run(f"{HEAD}\ndef test_fault():\n{code}")
    assert status != 0
    assert re.search(expected, said), said


def test_a_fault_in_a_process_that_is_to_fail_fails_the_run(seeded_run):
    code = "from comanip._core import lib; lib.float_nearest(1e30)"
    text = f"def test_child():\n    assert subprocess.run([sys.executable, '-c', '{code}']).returncode != 0\n"
    status, said = seeded_run(HEAD + text)
    assert "1 passed" in said
    assert status != 0 and "runtime error: 1e+30 is outside the range" in said


def test_without_a_fault_it_passes(seeded_run):
    status, said = seeded_run(f"{HEAD}\ndef test_none():\n    assert lib.float_nearest(2.5) in (2, 3)\n")
    assert (status, "1 passed" in said) == (0, True), said
