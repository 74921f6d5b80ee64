"""Computes the worst-case stack depth of the images (``make stack``).

``python -m comanip_dev.images.stack_report BUDGET.toml... REPORT.json IMAGE=FOLDER...``. The compiler provides the call
graph and the frame sizes (-fcallgraph-info=su); for library functions, both are read from the disassembly. The budgets
list the targets of calls through pointers. Unlisted calls through pointers and recursion are errors. The budgets also
list the parts of each stack, for example interrupts and faults. Each part may interrupt the previous part. The worst
case is the sum of the deepest calls of all parts, plus the registers that the processor saves. Exit status: 1 if a
stack exceeds its budget or has no bound, 2 for a usage error.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.table import Table

NODE = re.compile(r'^node: \{ title: "([^"]+)" label: "[^"]*?\\n(\d+) bytes \(([^)]*)\)')
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
FUNCTION = re.compile(r"^[0-9a-f]+ <([^>]+)>:$")
CALL = re.compile(r"\t(?:bl|blx|b\.w|b\.n|b|jal|j|call|tail|beq\.w|bne\.w)\s.*<([^>+]+)>")
PUSH = re.compile(r"\t(v?push|stmdb)\s+(?:sp!, )?\{([^}]*)\}")
SUB = re.compile(r"\tsub(?:w|\.w)?\s+sp, (?:sp, )?#(\d+)|\taddi\s+sp,sp,-(\d+)")
INDIRECT = "__indirect_call"


class UnboundedError(Exception):
    """No bound on the stack depth can be computed from the call graph."""


@dataclass
class Graph:
    """A call graph. Static functions are named FILE:NAME. frame: bytes on the stack for each function. calls: functions
    that each function calls."""

    frame: dict[str, int] = field(default_factory=dict)
    calls: dict[str, set[str]] = field(default_factory=dict)

    def depth(self, function: str, path: tuple[str, ...] = ()) -> tuple[int, tuple[str, ...]]:
        """Returns the depth in bytes and the functions on the deepest path. Raises UnboundedError for recursion."""
        if function in path:
            raise UnboundedError(f"recursion: {' -> '.join([*path[path.index(function) :], function])}")
        deepest, way = 0, ()
        for callee in sorted(self.calls.get(function, ())):
            below = self.depth(callee, (*path, function))
            if below[0] > deepest:
                deepest, way = below
        return self.frame[function] + deepest, (function, *way)


def plain(function: str) -> str:
    return function.rsplit(":", 1)[-1]


def read_call_graphs(folder: Path, graph: Graph) -> None:
    for path in sorted(folder.rglob("*.ci")):
        for line in path.read_text().splitlines():
            node, edge = NODE.match(line), EDGE.match(line)
            if node:
                if "dynamic" in node[3] and "bounded" not in node[3]:
                    raise UnboundedError(f"{node[1]}: its frame has no fixed size")
                graph.frame[node[1]] = int(node[2])
            elif edge:
                graph.calls.setdefault(edge[1], set()).add(edge[2])


def registers(kind: str, names: str) -> int:
    """Returns the number of bytes that a push instruction stores. Expands ranges of registers. FPU registers have 4
    bytes (s) or 8 bytes (d)."""
    count = 0
    for name in names.split(","):
        bounds = [int(n) for n in re.findall(r"(?<=[rsd])\d+", name)]
        count += bounds[1] - bounds[0] + 1 if len(bounds) == 2 else 1
    return count * (8 if kind == "vpush" and "d" in names else 4)


def read_disassembly(listing: str, graph: Graph) -> None:
    """Adds the functions of the disassembly that are not in the compiler's call graph."""
    function = None
    known = {plain(name) for name in graph.frame}
    for line in listing.splitlines():
        begin = FUNCTION.match(line)
        if begin:
            function = begin[1] if begin[1] not in known else None
            if function:
                graph.frame.setdefault(function, 0)
            continue
        if function is None:
            continue
        push, sub, call = PUSH.search(line), SUB.search(line), CALL.search(line)
        if push:
            graph.frame[function] += registers(push[1], push[2])
        elif sub:
            graph.frame[function] += int(sub[1] or sub[2])
        elif call and call[1] != function:
            graph.calls.setdefault(function, set()).add(call[1])


def resolve(graph: Graph, indirect: dict[str, list[str]]) -> None:
    """Replaces calls through pointers with calls to the targets that the budget lists. Drops callees that are not in
    the graph, because they were inlined or removed."""
    for function, callees in graph.calls.items():
        if INDIRECT in callees:
            if plain(function) not in indirect:
                raise UnboundedError(
                    f"{function} calls through a pointer, expected its targets under [indirect] of the budget"
                )
            callees.discard(INDIRECT)
            prefixes = tuple(indirect[plain(function)])
            callees |= {name for name in graph.frame if plain(name).startswith(prefixes)}
        for name in [name for name in callees if name not in graph.frame]:
            callees.discard(name)


def image_graph(folder: Path, objdump: str, indirect: dict[str, list[str]]) -> Graph:
    graph = Graph()
    read_call_graphs(folder, graph)
    command = [objdump, "-d", "--no-show-raw-insn", str(folder / "comanip.elf")]
    read_disassembly(subprocess.run(command, capture_output=True, text=True, check=True).stdout, graph)
    resolve(graph, indirect)
    return graph


def worst_case(graph: Graph, rules: dict) -> dict:
    """Returns the worst case of one stack. rules: the stack's table in the budget file."""
    parts = []
    for entries in rules["parts"]:
        missing = set(entries) - {plain(name) for name in graph.frame}
        if missing:
            raise UnboundedError(f"no such function: {', '.join(sorted(missing))}; correct `parts` in the budget")
        deepest, way = max(graph.depth(name) for name in graph.frame if plain(name) in entries)
        parts.append({"bytes": deepest, "path": [plain(name) for name in way]})
    worst = sum(part["bytes"] for part in parts) + rules["saved_bytes"]
    return {"worst_case_bytes": worst, "budget_bytes": rules["budget_bytes"], "parts": parts}


def read_budgets(paths: Sequence[str]) -> tuple[dict[str, list[str]], list[dict]]:
    """Returns the targets of calls through pointers for each caller, and the other sections of all files."""
    documents = [tomllib.loads(Path(path).read_text()) for path in paths]
    indirect = {caller: targets for document in documents for caller, targets in document.get("indirect", {}).items()}
    return indirect, [table for document in documents for name, table in document.items() if name != "indirect"]


def rules_of(image: str, sections: Sequence[dict]) -> dict:
    found = [section for section in sections if image in section.get("images", ())]
    if not found:
        raise UnboundedError(
            "no section lists this image: add a stack_budget.toml to the port's folder, or add the image to a section "
            "for the same core in hal/stack_budget.toml"
        )
    return found[0]


def main(argv: Sequence[str]) -> int:
    folders = dict(argument.split("=", 1) for argument in argv if "=" in argument)
    budgets = [argument for argument in argv if "=" not in argument and argument.endswith(".toml")]
    reports = [argument for argument in argv if "=" not in argument and argument.endswith(".json")]
    if not budgets or len(reports) != 1 or not folders:
        print(
            "usage: python -m comanip_dev.images.stack_report BUDGET.toml... REPORT.json IMAGE=FOLDER...",
            file=sys.stderr,
        )
        return 2
    indirect, sections = read_budgets(budgets)
    content, excesses = {}, []
    table = Table("image", "stack", "worst case", "budget", "deepest", title="Stacks in bytes", title_justify="left")
    for image, folder in folders.items():
        try:
            rules = rules_of(image, sections)
            graph = image_graph(Path(folder), rules["objdump"], indirect)
            content[image] = {stack: worst_case(graph, rules[stack]) for stack in ("thread", "exceptions")}
        except UnboundedError as error:
            print(f"make stack: {image}: {error}", file=sys.stderr)
            return 1
        for stack, found in content[image].items():
            worst, allowed = found["worst_case_bytes"], found["budget_bytes"]
            ways = ", then ".join(" > ".join(part["path"]) for part in found["parts"])
            table.add_row(image, stack, str(worst), str(allowed), ways)
            if worst > allowed:
                excesses.append(f"{image}: {stack}: {worst} bytes, budget {allowed}: {worst - allowed} too many")
    Console(width=160).print(table)
    report = Path(reports[0])
    report.parent.mkdir(parents=True, exist_ok=True)
    report.write_text(json.dumps(content, indent=1) + "\n")
    for line in excesses:
        print(f"make stack: {line}", file=sys.stderr)
    named = " and ".join(budgets)
    print(f"make stack: {named} is exceeded" if excesses else f"make stack: within {named}")
    return 1 if excesses else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
