"""Checks the directions of includes, both between the top folders (sim -> hal -> firmware; host_tools -> hal and
firmware) and between the folders within each of them.

``include_directions.py [ROOT]``, part of ``make check``. Reads every #include in the C sources under ROOT. Prints one
line for each forbidden include or, if there are none, for each cycle. The exit status is 1 if any line is printed.
tests/test_rooms.py does the same for the Python packages.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

# The includes allowed for a folder, or for one of its files, in addition to the folder itself. Each entry
# refers only to earlier entries, so that there can be no cycle. A folder of hal that is not listed is the port of a
# board and may include what BOARD lists.
MAY_USE = {
    "firmware/maths": [],
    "firmware/arms": ["firmware/maths"],
    "firmware/protocol": ["firmware/maths", "firmware/arms"],
    "firmware/safety": ["firmware/maths", "firmware/arms", "firmware/protocol"],  # never firmware/control
    "firmware/control": ["firmware/maths", "firmware/arms", "firmware/protocol", "firmware/safety"],
    "firmware/control/arms": ["firmware/maths", "firmware/arms", "firmware/protocol", "firmware/control"],
    "firmware/parameters": ["firmware/maths", "firmware/arms", "firmware/protocol", "firmware/control"],
    "firmware": [
        "firmware/maths", "firmware/arms", "firmware/protocol", "firmware/safety", "firmware/control",
        "firmware/parameters",
    ],
    "hal": ["firmware/protocol/can_frame.h", "firmware/protocol/can_profile.h", "firmware/protocol/port_status.h"],
    "firmware/main.c": ["firmware/arms", "firmware/control/arms", "firmware/parameters", "hal/hal.h"],
    "hal/common": ["firmware/protocol", "hal"],
    "hal/slcan": ["firmware/protocol", "hal", "hal/common"],
    "hal/lockstep": ["firmware/protocol", "hal", "hal/common", "hal/slcan"],
    "hal/cortex_m": ["firmware/main.h", "hal", "hal/common"],
    "hal/mps2": ["hal", "hal/common", "hal/cortex_m", "hal/slcan"],
    "hal/mps2_an505": ["hal", "hal/common", "hal/cortex_m", "hal/slcan", "hal/mps2"],
    "hal/linux": ["firmware/main.h", "firmware/protocol", "hal", "hal/common"],
    "sim/common": [],
    "sim/hand": ["sim/common"],
    "sim/robot": ["sim/common"],
    "sim/bus": ["firmware/protocol", "hal/common", "hal/linux"],
    "sim/scenario": ["firmware/protocol", "firmware/parameters", "sim/common", "sim/robot"],
    "sim/scene": ["sim/common", "sim/robot", "sim/scenario"],
    "sim/proximity": ["sim/common", "sim/scenario", "sim/scene"],
    "sim/feasibility": ["sim/common", "sim/robot", "sim/scenario", "sim/scene", "sim/proximity"],
    "sim/people": ["sim/common", "sim/hand", "sim/scenario", "sim/scene"],
    "sim/nodes": [
        "firmware/protocol", "firmware/parameters", "sim/common", "sim/hand", "sim/robot", "sim/bus", "sim/scenario",
        "sim/scene", "sim/proximity",
    ],
    "sim/monitors": [
        "firmware/arms/arm.h", "firmware/protocol", "firmware/parameters",
        "sim/common", "sim/hand", "sim/robot", "sim/bus", "sim/scenario", "sim/scene", "sim/proximity", "sim/nodes",
    ],
    "sim/options": ["firmware/protocol", "firmware/parameters", "hal/linux", "sim/scenario", "sim/nodes"],
    "sim/world": [
        "sim/common", "sim/hand", "sim/bus", "sim/scenario", "sim/scene", "sim/proximity", "sim/people", "sim/nodes",
        "sim/monitors", "sim/options",
    ],
    "sim/output": ["sim/common", "sim/bus", "sim/scenario", "sim/monitors", "sim/world"],
    "sim/port": ["firmware/main.h", "firmware/protocol", "hal", "hal/lockstep", "hal/slcan", "sim/world"],
    "sim/run": [
        "sim/bus", "sim/scenario", "sim/feasibility", "sim/options", "sim/world", "sim/output",
    ],
    "sim/programs": ["firmware/protocol", "hal/linux", "sim/bus", "sim/options", "sim/port", "sim/run"],
    "host_tools/comanip/_binding": [
        "firmware/maths", "firmware/arms", "firmware/protocol", "firmware/safety", "firmware/control",
        "firmware/parameters", "firmware", "hal/common",
    ],
    "host_tools/hub": ["hal/linux/hub_path.h"],
    "host_tools/shim": ["hal/linux/hub_path.h"],
}  # fmt: skip
BOARD = ["firmware/main.h", "hal", "hal/common", "hal/cortex_m", "hal/slcan"]

# Third-party libraries, and the folders that may use them.
LIBRARIES = {"ode/": ["sim/scene"], "ccd/": ["sim/proximity"], "yaml.h": ["sim/scenario"]}
# Standard headers allowed in the firmware and in hal.h. None of them provides files, a heap or a clock.
FIRMWARE_HEADERS = {"float.h", "math.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}

FOLDERS = ("firmware", "hal", "sim", "host_tools")
GENERATED = re.compile(r"comanip_\w+\.(h|inc)")  # generated from firmware/schema, found through -I
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)


class Include(NamedTuple):
    """An include of `target` in `file`, both relative to ROOT. A target outside ROOT is stored as written."""

    file: str
    line: int
    target: str
    is_own: bool


def includes(root: Path) -> Iterator[Include]:
    for path in sorted(file for folder in FOLDERS for file in (root / folder).rglob("*.[ch]")):
        file, text = path.relative_to(root).as_posix(), path.read_text()
        for match in INCLUDE.finditer(text):
            line = text.count("\n", 0, match.start(0)) + 1
            name = match[1] or match[2]
            own = [place / name for place in (path.parent, root) if match[1] and (place / name).is_file()]
            target = own[0].resolve().relative_to(root.resolve()).as_posix() if own else name
            yield Include(file, line, target, bool(own))


def folder_of(file: str) -> str:
    return file.rpartition("/")[0]


def allowed(file: str) -> list[str] | None:
    """Returns the folders and headers that the file may use, or None if the table does not list the file's folder."""
    folder = folder_of(file)
    found = MAY_USE.get(file, MAY_USE.get(folder))
    return BOARD if found is None and re.fullmatch(r"hal/\w+", folder) else found


def only(names: Iterable[str]) -> str:
    return f"only {text}" if (text := ", ".join(names)) else "nothing but itself"


def wrong_include(include: Include) -> str | None:
    """Returns the rule that the include violates, or None."""
    file, target, folder = include.file, include.target, folder_of(include.file)
    may_use = allowed(file)
    if may_use is None:
        return f"{folder} is not in the table of tests/check/include_directions.py: add it to MAY_USE"
    if include.is_own:
        is_allowed = folder_of(target) in (folder, *may_use) or target in may_use
        return None if is_allowed else f"{file if file in MAY_USE else folder} may use {only(may_use)}"
    for library, users in LIBRARIES.items():
        if target.startswith(library):
            return None if folder in users else f"{only(users)} may use it"
    if folder.startswith("firmware") and not GENERATED.fullmatch(target) and target not in FIRMWARE_HEADERS:
        return f"firmware may use {only(sorted(FIRMWARE_HEADERS))} of the standard library"
    return None


def cycle(graph: dict[str, set[str]]) -> list[str] | None:
    """Returns a path from a node back to itself, with this node at both ends, or None if there is no cycle."""
    done: set[str] = set()

    def search(node: str, way: list[str]) -> list[str] | None:
        if node in way:
            return [*way[way.index(node) :], node]
        if node in done:
            return None
        for after in sorted(graph.get(node, ())):
            if found := search(after, [*way, node]):
                return found
        done.add(node)
        return None

    return next((found for node in sorted(graph) if (found := search(node, []))), None)


def module_of(file: str, files: set[str]) -> str:
    """Returns the file's module. x.h and x.c are one module; x_part.h and x_part.c also belong to it if there is an
    x.h."""
    folder, name = folder_of(file), Path(file).stem
    words = name.split("_")
    for count in range(1, len(words)):
        if f"{folder}/{'_'.join(words[:count])}.h" in files:
            return f"{folder}/{'_'.join(words[:count])}"
    return f"{folder}/{name}"


def graph_of(edges: Iterable[tuple[str, str]]) -> dict[str, set[str]]:
    graph: dict[str, set[str]] = {}
    for a, b in edges:
        if a != b:
            graph.setdefault(a, set()).add(b)
    return graph


def problems(root: Path) -> list[str]:
    found = list(includes(root))
    own = [include for include in found if include.is_own]
    files = {name for include in own for name in (include.file, include.target)}
    lines = [f"{i.file}:{i.line}: includes {i.target}; {wrong}" for i in found if (wrong := wrong_include(i))]
    if lines:  # most cycles result from forbidden includes, so they are reported only when there are none
        return lines
    for what, name in (("files", lambda file: module_of(file, files)), ("folders", folder_of)):
        graph = graph_of((name(i.file), name(i.target)) for i in own if i.file != "firmware/main.c")
        while way := cycle(graph):
            lines.append(f"{what} in an include cycle: {' -> '.join(way)}")
            graph[way[-2]].discard(way[-1])
    return lines


def main(arguments: list[str]) -> int:
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parents[2]
    lines = problems(root)
    for line in lines:
        print(line, file=sys.stderr)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
