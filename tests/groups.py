"""Which tests run on one worker, one after the other, under `make test`, and why.

A file's tests always do. What takes longest begins first, so that all workers end at the same time.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """files: without `test_` and `.py`."""

    name: str
    files: tuple[str, ...]
    reason: str


GROUPS = (
    Group(
        "real time",
        ("two_processes", "comanip_on_a_hub", "can_tools", "parameter_file", "hub", "operator_commands", "monitor", "calibrate"),
        "processes or threads on a live bus, by the clock: none may take another's processor time",
    ),
    Group(
        "images",
        ("bitexact", "pil", "target", "port_folder", "size_report", "stack_report", "cycles"),
        "cross-compiled once into one folder, each in an emulator that takes a processor of its own",
    ),
)  # fmt: skip
# Of what is in no group, the files that take longer than half a minute.
LONG_FILES = ("experiments_physical", "recordings_campaign", "closed_loop", "package")

_GROUP_OF = {f"test_{file}.py": group for group in GROUPS for file in group.files}
_FILES = [*_GROUP_OF, *(f"test_{file}.py" for file in LONG_FILES)]


def group_of(test: str) -> str:
    """Of a test's id, the name of its group; of one in no group, its file."""
    file = test.partition("::")[0]
    return _GROUP_OF[file].name if file in _GROUP_OF else file


def place_of(test: str) -> int:
    """In the queue."""
    file = test.partition("::")[0]
    return _FILES.index(file) if file in _FILES else len(_FILES)


def told() -> list[str]:
    """For the head of `make test`."""
    return ["on one worker, one after the other:", *(f"  {group.name}: {group.reason}" for group in GROUPS)]
