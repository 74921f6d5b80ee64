"""Flash and RAM of the images, per module (``make size``).

``python -m comanip_dev.images.size_report BUDGET.toml REPORT.json [--update] IMAGE=MAP...``. The sizes come from the
linker's maps, after unused functions were removed. Each is compared with its budget, and each excess is printed.
``--update`` writes the present sizes as the new budget. Exit status: 1 if a size exceeds its budget, 2 wrong use.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

KINDS = ("text", "data", "bss")  # code and constants; variables with a value; variables that begin as 0
SECTION = re.compile(r"^\.(\w[\w.]*)(?:\s+0x[0-9a-f]+\s+0x([0-9a-f]+))?")
PART = re.compile(r"^ (?:\.\S+|COMMON|\*fill\*)?\s+0x([0-9a-f]+)\s+0x([0-9a-f]+)(?:\s+(\S.*))?\s*$")
PADDING, STACK = "padding", "stack"
HEAD = """# Maximum bytes of each image and of each module in it: `make size` fails above them. Written by `make size UPDATE=1` with
# the compilers of Debian 12; a change that needs more updates them, and gives the reason in its commit.
"""


@dataclass
class Size:
    """In bytes."""

    text: int = 0
    data: int = 0
    bss: int = 0


@dataclass
class Image:
    total: Size = field(default_factory=Size)
    modules: dict[str, Size] = field(default_factory=dict)

    def add(self, module: str, kind: str, size_bytes: int) -> None:
        for size in (self.total, self.modules.setdefault(module, Size())):
            setattr(size, kind, getattr(size, kind) + size_bytes)


def module_of(file: str, build: str) -> str:
    """The module of an object file, such as firmware/controller; a library counts as one module."""
    library = re.fullmatch(r".*/(lib\w+)\.a\(.*\)", file)
    if library:
        return library[1]
    return file.removeprefix(build).removesuffix(".o") if file.startswith(build) else Path(file).stem


def joined_lines(text: str) -> list[str]:
    """The lines of the map. A name too long for its column continues on the next line: joined here."""
    return re.sub(r"^( \.\S+)\n +(?=0x)", r"\1 ", text, flags=re.MULTILINE).splitlines()


def read_map(path: Path) -> Image:
    """The size of each module, from the map BUILD/IMAGE/comanip.map, which stands in the folder of the objects."""
    text = path.read_text()
    image, kind = Image(), None
    parts: list[tuple[str, int, int, str]] = []  # kind, address, bytes, module
    build = re.search(r"^LOAD (\S+?/" + re.escape(path.parent.name) + "/)", text, re.MULTILINE)[1]
    for line in joined_lines(text[text.index("Linker script and memory map") :]):
        section = SECTION.match(line)
        if section:
            kind = section[1] if section[1] in (*KINDS, STACK) else None
            if kind == STACK and section[2]:
                image.add(STACK, "bss", int(section[2], 16))
        elif kind in KINDS and (part := PART.match(line)):
            module = module_of(part[3], build) if part[3] else PADDING
            parts.append((kind, int(part[1], 16), int(part[2], 16), module))
    parts = sorted(part for part in parts if part[2] > 0)
    for (kind, address, size_bytes, module), following in zip(parts, [*parts[1:], None]):
        # Equal constants are told with every module that has them, and stand in the first.
        room = following[1] - address if following and following[0] == kind else size_bytes
        image.add(module, kind, min(size_bytes, room))
    image.modules = {name: size for name, size in sorted(image.modules.items()) if size != Size()}
    return image


# ---- budget


def read_budget(path: Path) -> dict[str, dict]:
    return tomllib.loads(path.read_text()) if path.exists() else {}


def budgeted(image: Image) -> dict[str, Size]:
    """The modules that have a budget: all but padding, which depends on all sizes and counts in the total."""
    return {"total": image.total, **{name: size for name, size in image.modules.items() if name != PADDING}}


def write_budget(path: Path, images: dict[str, Image]) -> None:
    lines = [HEAD]
    for name, image in images.items():
        rows = budgeted(image)
        lines += [f"[{name}]", *(f'"{module}" = {list(asdict(size).values())}' for module, size in rows.items()), ""]
    path.write_text("\n".join(lines).rstrip("\n") + "\n")


def excesses(images: dict[str, Image], budget: dict[str, dict]) -> list[str]:
    """One line for each size beyond its budget, and for each module without a budget."""
    told = []
    for name, image in images.items():
        for module, size in budgeted(image).items():
            allowed = budget.get(name, {}).get(module)
            if allowed is None:
                told.append(f"{name}: {module}: no budget")
                continue
            for kind, limit in zip(KINDS, allowed, strict=True):
                found = getattr(size, kind)
                if found > limit:
                    told.append(f"{name}: {module}: {kind} {found} bytes, budget {limit}: {found - limit} too many")
    return told


# ---- what is printed


WIDTH = 180  # so that no name is cut


def show(images: dict[str, Image], console: Console) -> None:
    table = Table(title="Bytes in the images: code and constants / variables with a value / others", title_justify="left", box=box.SIMPLE_HEAD,
                  padding=(0, 1, 0, 0))  # fmt: skip
    table.add_column("module", no_wrap=True)
    for name in images:
        table.add_column(name, justify="right")
    modules = sorted({module for image in images.values() for module in image.modules})
    for module in [*modules, "total"]:
        sizes = [image.total if module == "total" else image.modules.get(module) for image in images.values()]
        table.add_row(module, *("" if size is None else f"{size.text} / {size.data} / {size.bss}" for size in sizes))
    console.print(table)


def main(argv: Sequence[str]) -> int:
    maps = dict(argument.split("=", 1) for argument in argv[2:] if "=" in argument)
    if len(argv) < 3 or not maps:
        print(
            "usage: python -m comanip_dev.images.size_report BUDGET.toml REPORT.json [--update] IMAGE=MAP...",
            file=sys.stderr,
        )
        return 2
    budget_path, report = Path(argv[0]), Path(argv[1])
    images = {name: read_map(Path(path)) for name, path in maps.items()}
    show(images, Console(width=WIDTH))
    report.parent.mkdir(parents=True, exist_ok=True)
    content = {
        name: {
            "total_bytes": asdict(image.total),
            "modules_bytes": {m: asdict(size) for m, size in image.modules.items()},
        }
        for name, image in images.items()
    }
    report.write_text(json.dumps(content, indent=1) + "\n")
    if "--update" in argv:
        write_budget(budget_path, images)
        return 0
    told = excesses(images, read_budget(budget_path))
    for line in told:
        print(f"make size: {line}", file=sys.stderr)
    print(f"make size: beyond {budget_path}; UPDATE=1 writes it anew" if told else f"make size: within {budget_path}")
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
