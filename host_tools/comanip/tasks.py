"""Reads and checks the description of the built-in tasks, ``schema/tasks.toml``.

Errors are raised as ToolError, which names the file and the task and states what was found and what was expected.
"""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

from comanip.errors import ToolError

PATH = Path(__file__).with_name("schema") / "tasks.toml"
FORMS = ("constant", "mirrored")
CUSTOM_NUMBER, CUSTOM_NAME = 3, "custom"  # the task that the operator defines (TaskDefine)
NUMBERS = 256  # one byte on the bus
UNIT_TOLERANCE = 1e-6
_KEYS = ("number", "name", "form", "t_task_m", "q_task", "q_inv", "meaning")


@dataclass(frozen=True)
class Task:
    """A task. t_task_m: 3 values. q_task, q_inv: unit quaternions w x y z."""

    number: int
    name: str
    form: str
    t_task_m: tuple[float, ...]
    q_task: tuple[float, ...]
    q_inv: tuple[float, ...]
    meaning: str


def _task(path: Path, entry: dict) -> Task:
    def refusal(problem: str) -> ToolError:
        return ToolError(f"{path}: task '{entry.get('name', '?')}': {problem}")

    def numbers(key: str, count: int) -> tuple[float, ...]:
        values = entry[key]
        if not isinstance(values, list) or len(values) != count or not all(isinstance(x, int | float) for x in values):
            raise refusal(f"{key} {values!r}: expected {count} numbers")
        if count == 4 and abs(math.hypot(*values) - 1.0) > UNIT_TOLERANCE:
            raise refusal(f"{key} has norm {math.hypot(*values):.6g}, expected 1")
        return tuple(map(float, values))

    if sorted(entry) != sorted(_KEYS):
        raise refusal(f"keys {', '.join(sorted(entry))}: expected {', '.join(sorted(_KEYS))}")
    if not isinstance(entry["number"], int) or not 0 <= entry["number"] < NUMBERS or entry["number"] == CUSTOM_NUMBER:
        raise refusal(
            f"number {entry['number']!r}: expected 0 to {NUMBERS - 1} except {CUSTOM_NUMBER}, the custom task"
        )
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", str(entry["name"])) or entry["name"] == CUSTOM_NAME:
        raise refusal("expected a name of a-z, 0-9 and _, at most 31 characters, other than 'custom'")
    if entry["form"] not in FORMS:
        raise refusal(f"form {entry['form']!r}: expected one of {', '.join(FORMS)}")
    vectors = numbers("t_task_m", 3), numbers("q_task", 4), numbers("q_inv", 4)
    return Task(entry["number"], entry["name"], entry["form"], *vectors, str(entry["meaning"]))


def read(path: Path = PATH) -> list[Task]:
    """Returns the built-in tasks, sorted by number."""
    try:
        document = tomllib.loads(path.read_text())
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise ToolError(f"{path}: {error}") from error
    tasks: dict[int, Task] = {}
    for entry in document.get("task", []):
        task = _task(path, entry)
        if task.number in tasks:
            raise ToolError(
                f"{path}: task '{task.name}': number {task.number} is already used by '{tasks[task.number].name}', "
                f"expected an unused number other than {CUSTOM_NUMBER}"
            )
        if task.name in {other.name for other in tasks.values()}:
            raise ToolError(f"{path}: task '{task.name}': the name is used twice, expected once")
        tasks[task.number] = task
    if not tasks:
        raise ToolError(f"{path}: no [[task]], expected at least one")
    return [tasks[number] for number in sorted(tasks)]


def names(path: Path = PATH) -> dict[int, str]:
    """Returns the names of all tasks, including the custom task, by their numbers on the bus."""
    return dict(sorted({CUSTOM_NUMBER: CUSTOM_NAME, **{task.number: task.name for task in read(path)}}.items()))
