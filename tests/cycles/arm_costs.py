"""Computes the instruction cycles of Cortex-M4F, M3 and M0+ from ARM's tables.

The sources are the Technical Reference Manuals of Cortex-M4 (ARM DDI 0439), tables 3-1 and 7-1; of Cortex-M3 (ARM DDI
0337), table 3-1, which differs from that of Cortex-M4 only in multiplications; and of Cortex-M0+ (ARM DDI 0484), table
3-1, with the single-cycle multiplier. Where a table gives a range, its upper end is used: 3 for a pipeline refill, 12
for a division. Two neighbouring loads are assumed not to overlap. Flash wait states are not included. The results have
never been checked on silicon.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

# Additional cycles of a taken conditional branch, for images in which they differ from REFILL.
TAKEN = {"cortex-m0plus": 1}
REFILL = 3  # the tables call it P: "1 to 3, depending on the alignment and width of the target"
CONDITIONS = "(?:eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)"
LINE = re.compile(r"^\s*([0-9a-f]+):\t(\S+)(?:\t(.*))?$")
# Floating-point arithmetic. An instruction that uses the result immediately waits for one cycle (table 7-1, note).
LATE = re.compile(r"^v(add|sub|mul|nmul|mla|mls|nmla|nmls|fma|fms|div|sqrt|cvt)")


@dataclass(frozen=True)
class Instruction:
    address: int
    name: str
    operands: str

    @property
    def is_conditional_branch(self) -> bool:
        return bool(re.fullmatch(rf"b{CONDITIONS}(\.[nw])?|cbn?z|bx{CONDITIONS}|pop{CONDITIONS}(\.w)?", self.name))


def registers(operands: str) -> int:
    """Returns the number of registers in a list like {r4, r5, s16-s31}."""
    found = re.search(r"\{(.*)\}", operands)
    count = 0
    for part in found.group(1).split(",") if found else []:
        first, _, last = part.strip().partition("-")
        words = 2 if first.startswith("d") else 1
        count += words * (int(last[1:]) - int(first[1:]) + 1 if last else 1)
    return count


def taken_cycles(image: str) -> int:
    return TAKEN.get(image, REFILL)


def cycles_m0plus(instruction: Instruction) -> int:
    name = instruction.name.removesuffix(".n").removesuffix(".w")
    writes_pc = bool(re.search(r"\bpc\b", instruction.operands)) and name in ("pop", "mov", "add")
    if re.match(r"(push|pop|ldm|stm)", name):
        return 1 + registers(instruction.operands) + (2 if writes_pc else 0)
    if re.match(r"(ldr|str)", name):
        return 2
    if name == "bl" or re.match(r"(mrs|msr|dsb|dmb|isb)", name):
        return 3
    if name in ("b", "bx", "blx") or (writes_pc and name in ("mov", "add") and instruction.operands.startswith("pc")):
        return 2
    return 1


def own_cycles(instruction: Instruction, image: str) -> int:
    """Returns the instruction's cycles, excluding the extra cycles of a taken conditional branch and any wait for the
    previous result."""
    if image == "cortex-m0plus":
        return cycles_m0plus(instruction)
    name = re.sub(r"\.(n|w)$", "", instruction.name)
    operands = instruction.operands
    writes_pc = bool(re.search(r"\bpc\b", operands.split(";")[0])) and name.startswith(
        ("pop", "ldm", "ldr", "mov", "add")
    )
    refill = REFILL if writes_pc and not re.match(r"ldr.*\[pc|add.*, pc", f"{name} {operands}") else 0
    if re.match(r"v?(push|pop|ldm|stm)", name):
        return 1 + registers(operands) + refill
    if re.match(r"v(div|sqrt)", name):
        return 14
    if re.match(r"v(fma|fms|mla|mls|nmla|nmls|fnma|fnms)", name):
        return 3
    if re.match(r"v(ldr|str)", name):
        return 3 if re.match(r"d\d", operands) else 2
    if name.startswith("vmov") and len(operands.split(",")) > 2:
        return 2
    if name.startswith("v"):
        return 1
    if re.match(r"(ldrd|strd)", name):
        return 3 + refill
    if re.match(r"(ldr|str)", name):
        return 2 + refill
    if re.match(r"(tbb|tbh)", name):
        return 2 + REFILL
    if image == "cortex-m3" and re.match(r"[su](mull|mlal)", name):
        return 7 if "mlal" in name else 5
    if image == "cortex-m3" and re.match(r"ml[as]", name):
        return 2
    if re.match(r"[su]div", name):
        return 12
    if re.match(r"(mrs|msr)", name):
        return 2
    if instruction.is_conditional_branch:
        return 1
    if re.fullmatch(r"b|bl|bx|blx", name):
        return 1 + REFILL
    if re.match(r"(dsb|dmb|isb|wfi)", name):
        return 1 + REFILL
    return 1 + refill


def waits(before: Instruction, after: Instruction) -> bool:
    if not LATE.match(before.name) or not after.name.startswith("v"):
        return False
    result, _, _ = before.operands.partition(",")
    used = after.operands.split(";")[0]
    sources = used if re.match(r"v(str|cmp|push|stm|mla|mls|fma|fms|nm)", after.name) else used.partition(",")[2]
    return bool(re.search(rf"\b{re.escape(result.strip())}\b", sources))


def costs(disassembly: str, image: str) -> list[tuple[int, bool, int]]:
    """Returns (address, is a conditional branch, cycles) for each instruction in objdump's text, ordered by address."""
    result = []
    before: Instruction | None = None
    for line in disassembly.splitlines():
        found = LINE.match(line)
        if not found:
            before = None
            continue
        instruction = Instruction(
            int(found.group(1), 16), found.group(2), (found.group(3) or "").split("@")[0].split(";")[0]
        )
        late = before is not None and waits(before, instruction)
        result.append((instruction.address, instruction.is_conditional_branch, own_cycles(instruction, image) + late))
        before = instruction
    return sorted(result)
