"""Which tests run on one worker, one after the other, under `make test`, and why. All others go by their files.

A group's place in the table is its place in the queue: what takes longest begins first.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """tests: what the ids of its tests begin with."""

    name: str
    tests: tuple[str, ...]
    reason: str


GROUPS = (
    Group(
        "wall clock",
        ("test_two_processes.py", "test_comanip_on_a_hub.py", "test_can_tools.py", "test_hub.py", "test_parameter_file.py"),
        "processes on a bus in real time: none of them beside another",
    ),
)  # fmt: skip


def group_of(test: str) -> tuple[int, str]:
    """Place in the queue, and name, of the group of a test's id."""
    for place, group in enumerate(GROUPS):
        if test.startswith(group.tests):
            return place, group.name
    return len(GROUPS), test.partition("::")[0]
