"""Generates C headers from parameters.toml and tasks.toml, and updates the rows of comanip.dbc that repeat these files.

``comanip_parameters.h``: parameter_id_t, and COMANIP_PARAMETERS with an X-macro row for each parameter.
``comanip_tasks.h``: COMANIP_TASKS with an X-macro row for each built-in task.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from comanip.parameters import NUMBERS, Parameter
from comanip.tasks import CUSTOM_NAME, CUSTOM_NUMBER, Task

from comanip_dev.schema.messages import GENERATED


def number(value: float) -> str:
    """Returns a float literal, which the compiler rounds to float32."""
    return f"{value!r}f"


def parameters_header(parameters: Sequence[Parameter]) -> str:
    """Returns the header for parameters. A vector has one enumerator, whose value is the number of the vector's first
    component. The enumerator's comment begins with the number of components."""
    first: dict[str, list[Parameter]] = {}
    for parameter in parameters:
        first.setdefault(parameter.vector, []).append(parameter)
    names = []
    for vector, components in first.items():
        count = f"{len(components)}: " if len(components) > 1 else ""
        names += [
            f"    /* {count}{components[0].meaning} */",
            f"    PARAMETER_{vector.upper()} = {components[0].number},",
        ]
    rows = [
        f'    PARAMETER({p.number}, "{p.name}", {number(p.minimum)}, {number(p.maximum)}, {number(p.default)}, '
        f'{str(p.kind != "float").lower()}, "{p.unit}", "{p.group}", "{p.meaning}")'
        for p in parameters
    ]
    return "\n".join([
        GENERATED, "#ifndef COMANIP_PARAMETER_ROWS_H", "#define COMANIP_PARAMETER_ROWS_H", "",
        "/* The numbers on the bus. The components of a vector have consecutive numbers. */",
        "typedef enum {", *names,
        f"    PARAMETER_COUNT = {parameters[-1].number + 1} /* the largest number plus 1 */",
        "} parameter_id_t;", "",
        f"#define PARAMETER_NUMBERS {NUMBERS} /* upper limit of PARAMETER_COUNT */", "",
        "/* PARAMETER(number, name, minimum, maximum, default, whole numbers only, unit, group, meaning) */",
        "#define COMANIP_PARAMETERS(PARAMETER) \\", *(f"{row} \\" for row in rows[:-1]), rows[-1], "", "#endif", "",
    ])  # fmt: skip


def tasks_header(tasks: Sequence[Task]) -> str:
    def vector(values: tuple[float, ...]) -> str:
        return f"({', '.join(number(value) for value in values)})"

    largest = max(CUSTOM_NUMBER, *(task.number for task in tasks))
    rows = [
        f'    TASK({task.name.upper()}, {task.number}, "{task.name}", {task.form.upper()}, '
        f"{vector(task.t_task_m)}, {vector(task.q_task)}, {vector(task.q_inv)})"
        for task in tasks
    ]
    return "\n".join([
        GENERATED, "#ifndef COMANIP_TASKS_H", "#define COMANIP_TASKS_H", "",
        f"#define COMANIP_TASK_NUMBERS {largest + 1} /* the largest number plus 1 */",
        f"#define COMANIP_TASK_COUNT {len(tasks)} /* built-in tasks */", "",
        "/* TASK(NAME, number, name, form, (t_task), (q_task), (q_inv)) */",
        "#define COMANIP_TASKS(TASK) \\", *(f"{row} \\" for row in rows[:-1]), rows[-1], "", "#endif", "",
    ])  # fmt: skip


# ---- rows of the DBC


def _value_table(names: dict[int, str]) -> str:
    return " ".join(f'{value} "{name}"' for value, name in sorted(names.items()))


def with_names(text: str, signal: str, names: dict[int, str]) -> str:
    """Returns the text of the DBC, with these names as the value table of each signal called `signal`."""
    return re.sub(rf"^(VAL_ \d+ {signal}) .*;$", lambda m: f"{m[1]} {_value_table(names)} ;", text, flags=re.MULTILINE)


def _with_table(text: str, signal: str, names: dict[int, str]) -> str:
    """Works like with_names(), and also sets the range of the signals to the numbers that have names."""
    text = with_names(text, signal, names)
    return re.sub(rf"^( SG_ {signal} : \S+ \(1,0\)) \[0\|\d+\]", rf"\1 [0|{max(names)}]", text, flags=re.MULTILINE)


def dbc_with_tables(text: str, parameters: Sequence[Parameter], tasks: Sequence[Task]) -> str:
    """Returns the DBC with the names and ranges of these parameters and tasks."""
    text = _with_table(text, "parameter", {p.number: p.name for p in parameters})
    text = _with_table(text, "task", {CUSTOM_NUMBER: CUSTOM_NAME, **{t.number: t.name for t in tasks}})
    low, high = min(p.minimum for p in parameters), max(p.maximum for p in parameters)
    return re.sub(r"^( SG_ value : \S+ \(1,0\)) \[.*?\]", rf"\1 [{low:.7g}|{high:.7g}]", text, flags=re.MULTILINE)
