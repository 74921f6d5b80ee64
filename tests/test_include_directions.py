"""Checks that the checker's table permits each #include in the source tree, that the checker sees the same includes as
the compiler, and that it detects every kind of violation."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from simulation import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "check"))
import include_directions as check

CHECKER = REPOSITORY / "tests" / "check" / "include_directions.py"


@pytest.fixture
def tree(tmp_path) -> Path:
    """Returns a copy of the repository's C sources that tests may modify."""
    for folder in check.FOLDERS:
        for file in (REPOSITORY / folder).rglob("*.[ch]"):
            copy = tmp_path / file.relative_to(REPOSITORY)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
    return tmp_path


def add(tree: Path, file: str, include: str) -> int:
    """Appends a line to the file, creating it if necessary. Returns its line number."""
    path = tree / file
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [*(path.read_text().splitlines() if path.exists() else []), f"#include {include}"]
    path.write_text("\n".join(lines) + "\n")
    return len(lines)


def checked(tree: Path) -> tuple[int, list[str]]:
    done = subprocess.run([sys.executable, CHECKER, tree], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.splitlines()


def test_the_tree_follows_its_directions(tree):
    assert check.problems(REPOSITORY) == []
    assert checked(tree) == (0, [])


def test_the_table_allows_no_cycle():
    """A row of the table may name only rows above it, so the table allows no include cycle."""
    above = []
    for row, may_use in check.MAY_USE.items():
        for name in may_use:
            assert name in above or check.folder_of(name) in above, f"{row} may use {name}, which is not above it"
        above.append(row)


@pytest.mark.parametrize(
    "file",
    ["firmware/controller.c", "hal/linux/port.c", "sim/world/world.c", "sim/run/run.c", "host_tools/hub/hub.c"],
)
def test_it_reads_the_headers_that_the_compiler_reads(file):
    command = ["gcc", "-MM", "-D_GNU_SOURCE", "-Ibuild/generated", file]
    rule = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout
    names = rule.replace("\\\n", " ").split(":")[1].split()
    expected = {str((REPOSITORY / name).resolve().relative_to(REPOSITORY)) for name in names}
    graph = check.graph_of((i.file, i.target) for i in check.includes(REPOSITORY) if i.is_own)
    read, waiting = set(), [file]
    while waiting:
        read.add(name := waiting.pop())
        waiting += graph.get(name, set()) - read
    assert read == {name for name in expected if not name.startswith("build/")}


@pytest.mark.parametrize(
    ("file", "include", "target", "wrong"),
    [
        ("firmware/maths/pose.h", '"../control/task.h"', "firmware/control/task.h",
         "firmware/maths may use nothing but itself"),
        ("firmware/controller.c", '"../hal/hal.h"', "hal/hal.h", "firmware may use only firmware/maths, "),
        ("firmware/protocol/e2e.c", "<stdio.h>", "stdio.h", "firmware may use only float.h, math.h, "),
        ("hal/hal.h", '"../firmware/controller.h"', "firmware/controller.h",
         "hal may use only firmware/protocol/can_frame.h, "),
        ("hal/linux/pace.h", '"../../sim/world/world.h"', "sim/world/world.h",
         "hal/linux may use only firmware/main.h, "),
        ("hal/linux/pace.c", '"../../host_tools/hub/hub.h"', "host_tools/hub/hub.h",
         "hal/linux may use only firmware/main.h, "),
        ("hal/new_board/port.c", '"../linux/pace.h"', "hal/linux/pace.h",
         "hal/new_board may use only firmware/main.h, "),
        ("sim/scenario/scenario.h", '"../scene/scene.h"', "sim/scene/scene.h",
         "sim/scenario may use only firmware/protocol, "),
        ("sim/scenario/yaml_reader.c", "<ode/ode.h>", "ode/ode.h", "only sim/scene may use it"),
        ("sim/world/world.h", '"../output/report.h"', "sim/output/report.h", "sim/world may use only sim/common, "),
        ("sim/new_room/a.h", '"../world/world.h"', "sim/world/world.h", "sim/new_room is not in the table of "),
        ("host_tools/hub/hub.c", '"../../sim/bus/bus.h"', "sim/bus/bus.h",
         "host_tools/hub may use only hal/linux/hub_path.h"),
    ],
)  # fmt: skip
def test_an_include_against_the_direction_is_one_line(tree, file, include, target, wrong):
    line = add(tree, file, include)
    status, lines = checked(tree)
    assert status == 1
    assert len(lines) == 1 and lines[0].startswith(f"{file}:{line}: includes {target}; {wrong}")


def test_files_in_an_include_cycle_are_named(tree):
    for file, include in [
        ("a.c", '"b.h"'),
        ("b.h", "<stdbool.h>"),
        ("b.c", '"c.h"'),
        ("c.h", '"a.h"'),
        ("a.h", "<math.h>"),
    ]:
        add(tree, f"sim/common/{file}", include)
    assert checked(tree) == (
        1,
        ["files in an include cycle: sim/common/a -> sim/common/b -> sim/common/c -> sim/common/a"],
    )


def test_parts_of_a_file_may_use_what_it_declares(tree):
    add(tree, "sim/common/whole.c", '"whole_part.h"')
    add(tree, "sim/common/whole_part.h", '"whole.h"')
    add(tree, "sim/common/whole.h", "<math.h>")
    assert checked(tree) == (0, [])


def test_folders_in_an_include_cycle_are_named_even_if_the_table_allows_it(tree, monkeypatch):
    monkeypatch.setitem(check.MAY_USE, "sim/common", ["sim/hand"])
    add(tree, "sim/common/names.h", '"../hand/tremor.h"')
    lines = check.problems(tree)
    assert "folders in an include cycle: sim/common -> sim/hand -> sim/common" in lines
