"""Defines which test files `make test` runs one after the other on the same worker, and why.

All tests of one file run on the same worker. The longest groups start first, so that all workers finish at about the
same time.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """A group of test files. `files` holds the file names without `test_` and `.py`."""

    name: str
    files: tuple[str, ...]
    reason: str


GROUPS = (
    Group(
        "real time",
        ("two_processes", "comanip_on_a_hub", "can_tools", "parameter_file", "port_status", "hub", "operator_commands",
         "monitor", "calibrate"),
        "they run processes or threads on a live bus, with time limits, and must not compete for the processor",
    ),
    Group(
        "images",
        ("bitexact", "pil", "target", "port_folder", "size_report", "stack_report", "cycles"),
        "they share images in one folder, cross-compiled once, and each emulator occupies a whole processor",
    ),
)  # fmt: skip
# Files outside any group that take longer than half a minute.
LONG_FILES = ("experiments_physical", "recordings_campaign", "closed_loop", "package")

_GROUP_OF = {f"test_{file}.py": group for group in GROUPS for file in group.files}
_FILES = [*_GROUP_OF, *(f"test_{file}.py" for file in LONG_FILES)]


def group_of(test: str) -> str:
    """Returns the name of the group that a test belongs to, or the test's file if it belongs to no group."""
    file = test.partition("::")[0]
    return _GROUP_OF[file].name if file in _GROUP_OF else file


def position_of(test: str) -> int:
    """Returns the position of a test in the run order."""
    file = test.partition("::")[0]
    return _FILES.index(file) if file in _FILES else len(_FILES)


def header() -> list[str]:
    """Returns the header lines that `make test` prints."""
    return ["on one worker, one after the other:", *(f"  {group.name}: {group.reason}" for group in GROUPS)]
