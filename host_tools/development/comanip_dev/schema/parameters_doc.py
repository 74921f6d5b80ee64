"""docs/parameters.md, written from parameters.toml: ``python -m comanip_dev.schema.parameters_doc FILE``."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from comanip.parameters import Parameter, read

from comanip_dev.bus.doc import table

HEAD = """# Parameters

Written by `make schema` from `firmware/schema/parameters.toml`, the one place where parameters are described: do not edit.

`comanip param list` shows the values in force; `comanip param set NAME VALUE` writes one while the arm is at rest, and
`comanip param save` keeps all of them for the next boot. In the simulator: `--param NAME=VALUE`. A value out of range is
refused and changes nothing.
"""


def markdown(parameters: Iterable[Parameter]) -> str:
    """The whole text: a table for each group, in the order of the numbers."""
    groups: dict[str, list[Parameter]] = {}
    for parameter in parameters:
        groups.setdefault(parameter.group, []).append(parameter)
    lines = [HEAD.rstrip("\n")]
    for group, members in groups.items():
        lines += ["", f"## {group[0].upper()}{group[1:]}", ""]
        rows = [
            [
                f"`{p.name}`",
                str(p.number),
                p.unit,
                p.kind,
                f"{p.minimum:g} to {p.maximum:g}",
                f"{p.default:g}",
                p.meaning,
            ]
            for p in members
        ]
        lines += table(("parameter", "number", "unit", "type", "range", "default", "meaning"), rows)
    return "\n".join(lines) + "\n"


def main(argv: list[str]) -> int:
    if len(argv) != 1:
        print("usage: python -m comanip_dev.schema.parameters_doc FILE", file=sys.stderr)
        return 2
    Path(argv[0]).write_text(markdown(read()))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
