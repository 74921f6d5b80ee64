"""Checks `make cycles`: the modelled cycles of single instructions against ARM's tables, the counter against a loop
whose number of cycles is known, and the budget."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest
from images import IMAGES
from simulation import PATIENCE_S, REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tests" / "cycles"))

import arm_costs  # noqa: E402
import cycles  # noqa: E402
import operated  # noqa: E402


def modelled(*lines: str, image: str = "cortex-m4f") -> list[tuple[bool, int]]:
    text = "\n".join(f"    {4 * i:x}:\t{line}" for i, line in enumerate(lines))
    return [(branch, cost) for _, branch, cost in arm_costs.costs(text, image)]


@pytest.mark.parametrize(
    ("line", "cost"),
    [  # ARM DDI 0439, tables 3-1 and 7-1, with P = 3
        ("add\tr0, r1, r2", 1), ("ldr\tr0, [r1, #4]", 2), ("ldrd\tr0, r1, [r2]", 3), ("push\t{r4, r5, lr}", 4),
        ("pop\t{r4, pc}", 6),
        ("ldr\tr2, [pc, #8]", 2), ("b.n\t20 <x>", 4), ("bl\t20 <x>", 4), ("bx\tlr", 4), ("udiv\tr0, r1, r2", 12),
        ("smull\tr0, r1, r2, r3", 1),
        ("vadd.f32\ts0, s1, s2", 1), ("vmul.f32\ts0, s1, s2", 1), ("vfma.f32\ts0, s1, s2", 3),
        ("vdiv.f32\ts0, s1, s2", 14),
        ("vsqrt.f32\ts0, s1", 14), ("vldr\ts0, [r0, #4]", 2), ("vpush\t{s16-s20}", 6), ("vpop\t{d8-d9}", 5),
        ("vmrs\tAPSR_nzcv, fpscr", 1),
    ],
)  # fmt: skip
def test_the_model_matches_arms_table(line, cost):
    assert modelled(line) == [(False, cost)]


def test_a_result_that_is_needed_at_once_costs_a_cycle():
    assert modelled("vadd.f32\ts0, s1, s2", "vmul.f32\ts3, s0, s1") == [(False, 1), (False, 2)]
    assert modelled("vadd.f32\ts0, s1, s2", "vmul.f32\ts3, s4, s1") == [(False, 1), (False, 1)]
    assert modelled("vadd.f32\ts1, s1, s2", "vstr\ts1, [r0]") == [(False, 1), (False, 3)]
    assert modelled("vadd.f32\ts1, s1, s2", "vmul.f32\ts12, s11, s10") == [(False, 1), (False, 1)]


@pytest.mark.parametrize("line", ["beq.n\t20 <x>", "bne.w\t20 <x>", "cbz\tr0, 20 <x>", "bxeq\tlr"])
def test_a_conditional_branch_is_recognised(line):
    assert modelled(line) == [(True, 1)]


def test_multiplications_of_cortex_m3_take_longer():
    assert modelled("umull\tr0, r1, r2, r3", image="cortex-m3") == [(False, 5)]
    assert modelled("mla\tr0, r1, r2, r3", image="cortex-m3") == [(False, 2)]


@pytest.mark.parametrize(
    ("line", "cost"),
    [  # ARM DDI 0484, table 3-1
        ("adds\tr0, r1, r2", 1), ("muls\tr0, r1", 1), ("ldr\tr0, [r1, #4]", 2), ("str\tr0, [r1, #4]", 2),
        ("ldr\tr2, [pc, #8]", 2),
        ("push\t{r4, r5, lr}", 4), ("pop\t{r4, r5}", 3), ("pop\t{r4, pc}", 5), ("b.n\t20 <x>", 2), ("bl\t20 <x>", 3),
        ("bx\tlr", 2),
        ("add\tr1, pc, #8", 1), ("mov\tpc, r2", 2), ("mrs\tr0, PRIMASK", 3),
    ],
)  # fmt: skip
def test_the_model_of_cortex_m0plus_matches_arms_table(line, cost):
    assert modelled(line, image="cortex-m0plus") == [(False, cost)]


def test_an_exceeded_budget_is_reported_with_the_difference():
    found = {"cortex-m4f": {"tick": {"instructions": 630, "cycles": 850}, "step": {"instructions": 10}}}
    budget = {"cortex-m4f": {"tick": {"instructions": 627, "cycles": 850}}}
    assert cycles.exceeded(found, budget) == [
        "cortex-m4f: tick: 630 instructions, budget 627: 3 too many",
        "cortex-m4f: step: instructions has no budget",
    ]


def test_a_missed_requirement_is_reported():
    results = {
        image: {
            states: {
                name: {unit: {"maximum": 700} for unit in ("instructions", "cycles")}
                for name in ("step", "step_not_predicted", "tick", "joint_watch")
            }
            for states in ("recorded", "not_predicted")
        }
        for image in ("cortex-m4f", "cortex-m3")
    }
    assert cycles.missed(results) == []
    results["cortex-m4f"]["recorded"]["step"]["instructions"]["maximum"] = 10_001
    results["cortex-m3"]["not_predicted"]["step_not_predicted"]["cycles"]["maximum"] = 72_001
    results["cortex-m4f"]["recorded"]["joint_watch"]["instructions"]["maximum"] = 2001
    assert cycles.missed(results) == [
        "cortex-m4f, recorded: joint_watch: maximum of instructions 2001, required 2000",
        "cortex-m4f, recorded: step: maximum of instructions 10001, required 10000",
        "cortex-m3, not_predicted: step_not_predicted: maximum of cycles 72001, required 72000",
    ]


def test_the_operated_states_include_each_kind():
    seen = operated.run(cycles.OPERATED_TICKS, seed=3).seen
    kinds = (
        "start",
        "select",
        "latch",
        "clutch",
        "define",
        "read",
        "stop",
        "demand deferred",
        "hold",
        "a joint at its limit",
    )
    assert all(seen[kind] >= 10 for kind in kinds), seen


@pytest.mark.skipif(
    not (shutil.which("qemu-system-arm") and shutil.which("arm-none-eabi-gcc")), reason="needs make target-deps"
)
def test_the_counter_is_exact(tmp_path):
    """The counts are exact for a loop of known length, with 100 subtractions and branches. All branches except the last
    are taken."""
    source = tmp_path / "loop.S"
    source.write_text("""
        .syntax unified
        .thumb
        .section .text
        .word 0x20001000, start + 1
        .thumb_func
        start: bl count_begin
        movs r0, #100
        1: subs r0, #1
        bne 1b
        bl count_end
        ldr r1, =0x20026
        movs r0, #0x18
        bkpt 0xAB
        b .
        .thumb_func
        .global count_begin
        count_begin: bx lr
        .thumb_func
        .global count_end
        count_end: bx lr
    """)
    elf, plugin = tmp_path / "loop.elf", tmp_path / "plugin.so"
    for command in (
        ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-nostdlib", "-Wl,-Ttext=0", "-o", elf, source],
        ["gcc", "-shared", "-fPIC", REPOSITORY / "tests" / "cycles" / "plugin.c", "-o", plugin],
    ):
        subprocess.run(list(map(str, command)), check=True)
    costs = cycles.write_costs("cortex-m4f", elf)
    begin, end = (hex(cycles.symbol("cortex-m4f", elf, name)) for name in ("count_begin", "count_end"))
    argument = f"{plugin},begin={begin},end={end},costs={costs},out={tmp_path / 'counts.bin'}"
    machine = [*IMAGES["cortex-m4f"].emulator, *cycles.bitexact.SEMIHOSTING]
    subprocess.run(
        [*machine, "-plugin", argument, "-kernel", str(elf)], check=True, stdin=subprocess.DEVNULL, timeout=PATIENCE_S
    )
    (pair,) = cycles.np.fromfile(tmp_path / "counts.bin", "<u4").reshape(-1, 2)
    # instructions: bx lr, movs, 100 x (subs, bne), bl; cycles: 4 + 1 + 100 x 2 + 99 x 3 + 4
    assert list(pair) == [1 + 1 + 200 + 1, 4 + 1 + 200 + 297 + 4]
