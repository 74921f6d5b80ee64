"""``make cycles``: determines the instructions and modelled cycles of one tick in each image. The inputs are recorded
runs, a run in which an operator changes something every few ticks ("operated"), and adversarial values.

``cycles.py BUILD BUDGET.toml [--update]``. Instructions are counted in QEMU by plugin.c. Cycles are computed from ARM's
tables (arm_costs.py) for Cortex-M4F, M3 and M0+; they have never been measured on silicon. Prints a table, writes
BUILD/reports/cycles.json and compares the maxima with BUDGET.toml. If a budget or a requirement is exceeded, prints
the differences and exits with status 1. --update writes the maxima to BUDGET.toml.

The quantities are:

    step                controller_step() as a whole
    estimate            with prediction: processing of one hand sample
    prediction          with prediction: the hand's pose and motion at the time of the command, and the target's motion
    law                 with prediction: Algorithm 1 and the control law with position priority, no joint at a limit
    law_ends            the same as `law` with all joints at limits, in which case the law is solved again
    tick                without prediction: Algorithm 1, kinematics and control law (4) with the default parameters, no
                        joint at a limit and no task being blended in
    tick_torso          the same as `tick` with the error in the torso frame
    tick_general        the same as `tick` with a weight that requires the general solution
    tick_ends           the same as `tick` with all joints at limits
    tick_general_ends   the same as `tick_general` with all joints at limits
    tick_blend          the same as `tick` while a task is being blended in
    step_not_predicted  controller_step() in recorded ticks with prediction switched off
"""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "tests"), str(REPOSITORY / "tests" / "bitexact")]

import arm_costs  # noqa: E402
import bitexact  # noqa: E402
import operated  # noqa: E402
import stimulus  # noqa: E402
from images import EMULATED, IMAGES, make  # noqa: E402

STATES = 10_000
OPERATED_TICKS = 18_000  # enough to count the control law STATES times
TIMEOUT_S = 900  # needed because an image that panics halts, and its emulator never ends
STATE = 3  # as in records.h
NOTHING = 0  # COUNTED_NOTHING of program.c; the keys of QUANTITIES are the other values of counted_t
TARGET_REACH_M = (1e-6, 0.3, 3.0)
QUANTITIES = {1: "step", 2: "tick", 3: "tick_torso", 4: "tick_general", 5: "tick_ends", 6: "tick_general_ends",
              7: "tick_blend",
              8: "estimate", 9: "prediction", 10: "law", 11: "law_ends", 12: "step_not_predicted",
              13: "joint_watch"}  # fmt: skip
LABELS = {"step": "controller_step()", "tick": "law (4)", "tick_torso": "(4), torso frame",
          "tick_general": "(4), general", "tick_ends": "(4), joints at limits",
          "tick_general_ends": "(4) general, at limits", "tick_blend": "(4), a task is blended in",
          "step_not_predicted": "prediction off", "estimate": "one hand sample",
          "joint_watch": "safety: all joints", "prediction": "hand's and target's motion", "law": "position priority",
          "law_ends": "joints at limits"}  # fmt: skip
MODELLED = ("cortex-m3", "cortex-m4f", "cortex-m0plus")
NOT_PREDICTED = {"step_not_predicted"}  # the only quantities counted with prediction off
INPUTS = ("recorded", "not_predicted", "operated", "adversarial")
# Requirements of the product: image, input, quantity, unit, statistic, upper limit.
REQUIRED = (("cortex-m4f", "recorded", "tick", "instructions", "maximum", 800),
            ("cortex-m4f", "recorded", "tick", "cycles", "maximum", 850),
            ("cortex-m4f", "recorded", "joint_watch", "instructions", "maximum", 2000),
            # 8,000 without the safety layer, and what that may take
            ("cortex-m4f", "recorded", "step", "instructions", "maximum", 10_000),
         ("cortex-m3", "recorded", "step", "cycles", "maximum", 120_000),
         ("cortex-m3", "not_predicted", "step_not_predicted", "cycles", "maximum", 72_000))  # fmt: skip
COSTS = struct.Struct("<II")


def recorded(folder: Path, *options: str) -> bytes:
    """Records the same number of ticks from each of three scenarios. There are more than STATES ticks, because the
    control law runs only in those in which the robot cooperates, and must run STATES times."""
    parts = []
    for scenario in ("pour", "teleop", "mirror"):
        out = folder / "runs" / "-".join([scenario, *options])
        command = [str(bitexact.SIMULATOR), "--scenario", scenario, "--quiet", "--out", str(out), *options]
        (out / "bus.log").unlink(missing_ok=True)  # so that no old log is used if the run fails
        subprocess.run(command, check=False, stderr=subprocess.DEVNULL)
        parts += islice(stimulus.recorded(out / "bus.log"), 1 + STATES // 2)
    return b"".join(parts)


def adversarial(rng: np.random.Generator) -> bytes:
    """Generates random frames, and arm states at joint limits, at singularities and out of range, with near and far
    targets."""
    parts = list(stimulus.vectors(STATES, 1))
    parts.append(stimulus.boot(0))
    low, high = np.radians([-90, -95, -90, -114]), np.radians([150, 0, 90, 0])
    for number in range(STATES):
        q = rng.uniform(low, high)
        if number % 4 == 1:
            q = np.where(rng.random(4) < 0.5, low, high)
        elif number % 4 == 2:
            q = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi, 1e-30, -0.0], 4)
        elif number % 4 == 3:
            q = rng.uniform(-64, 64, 4)
        rotation = rng.normal(size=4) if number % 3 else np.array([rng.choice([-1, 1]), 0, 0, 1e-7])
        position = rng.uniform(-1, 1, 3) * rng.choice(TARGET_REACH_M)
        values = np.concatenate([q, rotation / np.linalg.norm(rotation), position]).astype("<f4")
        parts.append(stimulus.HEAD.pack(0, STATE, number % 3) + values.tobytes())
    return b"".join(parts)


def output_of(command: list[str]) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def build_image(folder: Path, image: str) -> Path:
    elf = folder / "target" / image / "comanip.elf"
    built = make(str(elf), "TARGET_MAIN=tests/cycles/program.c", "PROFILE=fd", f"TARGET_BUILD={folder / 'target'}")
    if built.returncode != 0:
        raise SystemExit(f"make cycles: {image}: {built.stderr}")
    return elf


def write_costs(image: str, elf: Path) -> Path:
    path = elf.with_name("costs.bin")
    costs = []
    if image in MODELLED:
        costs = arm_costs.costs(
            output_of([IMAGES[image].prefix + "objdump", "-d", "--no-show-raw-insn", str(elf)]), image
        )
    path.write_bytes(
        struct.pack("<I", arm_costs.taken_cycles(image))
        + b"".join(COSTS.pack(a | branch, cost) for a, branch, cost in costs)
    )
    return path


def symbol(image: str, elf: Path, name: str) -> int:
    rows = (line.split() for line in output_of([IMAGES[image].prefix + "nm", str(elf)]).splitlines())
    return next(int(row[0], 16) for row in rows if row[-1] == name)


def count(folder: Path, plugin: Path, image: str, states: str) -> dict[str, dict[str, np.ndarray]]:
    """Returns, for each quantity, the instructions and cycles of every pass that was counted."""
    elf = folder / "target" / image / "comanip.elf"
    place = folder / f"{image}-{states}"
    place.mkdir(exist_ok=True)
    (place / "input.bin").unlink(missing_ok=True)
    (place / "input.bin").symlink_to(folder / f"{states}.bin")
    options = {"begin": hex(symbol(image, elf, "count_begin")), "end": hex(symbol(image, elf, "count_end")),
               "costs": elf.with_name("costs.bin"), "out": place / "counts.bin"}  # fmt: skip
    argument = ",".join([str(plugin), *(f"{name}={value}" for name, value in options.items())])
    command = [*IMAGES[image].emulator, *bitexact.SEMIHOSTING, "-plugin", argument, "-kernel", str(elf)]
    subprocess.run(command, cwd=place, check=True, stdin=subprocess.DEVNULL, timeout=TIMEOUT_S)
    marks = np.frombuffer((place / "output.bin").read_bytes(), np.uint8)
    counts = np.fromfile(place / "counts.bin", "<u4").reshape(-1, 2)
    if len(counts) != len(marks) or marks[0] != NOTHING:
        raise SystemExit(
            f"make cycles: {image}, {states}: plugin.c counted {len(counts)} passes, program.c reported {len(marks)}; "
            f"expected equal numbers, and {NOTHING} as the first report"
        )
    counts = counts.astype(np.int64) - counts[0]  # the first pass is empty: it is the cost of the marks themselves
    quantities = NOT_PREDICTED if states == "not_predicted" else set(QUANTITIES.values()) - NOT_PREDICTED
    if (
        fewest := min(np.count_nonzero(marks == mark) for mark, name in QUANTITIES.items() if name in quantities)
    ) < STATES:
        raise SystemExit(
            f"make cycles: {image}, {states}: a quantity was counted {fewest} times, expected {STATES} times or more"
        )
    return {name: {"instructions": counts[marks == mark, 0], "cycles": counts[marks == mark, 1]}
            for mark, name in QUANTITIES.items() if name in quantities}  # fmt: skip


def figures(values: np.ndarray) -> dict[str, int]:
    most = int(np.percentile(values, 99.9, method="higher"))
    return {
        "n": len(values),
        "minimum": int(values.min()),
        "median": int(np.median(values)),
        "percentile_99_9": most,
        "maximum": int(values.max()),
    }


def report(results: dict[str, dict]) -> None:
    table = Table(
        title="Instructions per tick (QEMU), and cycles by ARM's tables: minimum / median / 99.9 % / maximum",
        title_justify="left",
    )
    for header in ("image", "states", "quantity", "n", "instructions", "cycles (modelled)"):
        table.add_column(header, justify="left" if header in ("image", "states", "quantity") else "right")
    for image, of_image in results.items():
        table.add_section()
        for states, of_states in of_image.items():
            for name, units in of_states.items():
                cells = [
                    " / ".join(str(units[unit][key]) for key in ("minimum", "median", "percentile_99_9", "maximum"))
                    if unit in units
                    else "-"
                    for unit in ("instructions", "cycles")
                ]
                table.add_row(image, states, f"{name}: {LABELS[name]}", str(units["instructions"]["n"]), *cells)
    Console(width=165).print(table)


def maxima(results: dict[str, dict]) -> dict[str, dict[str, dict[str, int]]]:
    """Returns the maximum over all inputs, by image, quantity and unit."""
    return {
        image: {
            name: {
                unit: max(of_image[states][name][unit]["maximum"] for states in of_image if name in of_image[states])
                for unit in units
            }
            for name, units in {**of_image["recorded"], **of_image["not_predicted"]}.items()
        }
        for image, of_image in results.items()
    }


def exceeded(found: dict[str, dict], budget: dict[str, dict]) -> list[str]:
    lines = []
    for image, quantities in found.items():
        for name, units in quantities.items():
            for unit, value in units.items():
                allowed = budget.get(image, {}).get(name, {}).get(unit)
                if allowed is None:
                    lines.append(f"{image}: {name}: {unit} has no budget")
                elif value > allowed:
                    lines.append(f"{image}: {name}: {value} {unit}, budget {allowed}: {value - allowed} too many")
    return lines


def requirements(results: dict[str, dict]) -> list[tuple[str, int, int]]:
    """Returns the description, value and upper limit of each requirement."""
    return [(f"{image}, {states}: {name}: {which} of {unit}", results[image][states][name][unit][which], limit)
            for image, states, name, unit, which, limit in REQUIRED]  # fmt: skip


def missed(results: dict[str, dict]) -> list[str]:
    """Returns a line for each value that exceeds its requirement."""
    return [f"{what} {value}, required {limit}" for what, value, limit in requirements(results) if value > limit]


def main(argv: list[str]) -> int:
    build, budget = Path(argv[0]).resolve(), Path(argv[1])
    images = EMULATED
    if missing := sorted({program for image in images if not shutil.which(program := IMAGES[image].emulator[0])}):
        print(f"make cycles: not found: {', '.join(missing)}. On Debian or Ubuntu: make target-deps", file=sys.stderr)
        return 1
    folder = build / "cycles"
    folder.mkdir(parents=True, exist_ok=True)
    plugin = folder / "plugin.so"
    subprocess.run(
        [
            "gcc",
            "-O2",
            "-shared",
            "-fPIC",
            "-Wall",
            "-Wextra",
            "-Werror",
            str(Path(__file__).with_name("plugin.c")),
            "-o",
            str(plugin),
        ],
        check=True,
    )
    (folder / "recorded.bin").write_bytes(recorded(folder))
    (folder / "not_predicted.bin").write_bytes(recorded(folder, "--param", "prediction=0"))
    (folder / "operated.bin").write_bytes(b"".join(operated.operated(OPERATED_TICKS, seed=3)))
    (folder / "adversarial.bin").write_bytes(adversarial(np.random.default_rng(2)))
    for image in images:
        write_costs(image, build_image(folder, image))
    jobs = [(image, states) for image in images for states in INPUTS]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        counted = dict(zip(jobs, pool.map(lambda job: count(folder, plugin, *job), jobs), strict=True))
    results = {
        image: {
            states: {
                name: {unit: figures(v) for unit, v in units.items() if unit == "instructions" or image in MODELLED}
                for name, units in counted[image, states].items()
            }
            for states in INPUTS
        }
        for image in images
    }
    path = build / "reports" / "cycles.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=1) + "\n")
    report(results)
    for what, value, limit in requirements(results):
        print(f"required of {what}: at most {limit}; measured {value}")
    found = maxima(results)
    if "--update" in argv:
        lines = ["# Budget of a tick, checked by `make cycles`, written by `make cycles UPDATE=1`.\n"]
        for image, quantities in found.items():
            lines.append(f"\n[{image}]\n")
            lines += [
                f"{name} = {{ {', '.join(f'{u} = {v}' for u, v in units.items())} }}\n"
                for name, units in quantities.items()
            ]
        budget.write_text("".join(lines))
        print(f"make cycles: {budget} written")
    over = missed(results) + exceeded(found, tomllib.loads(budget.read_text()) if budget.exists() else {})
    for line in over:
        print(f"make cycles: {line}", file=sys.stderr)
    print(
        f"make cycles: above {budget} or a requirement; UPDATE=1 updates the budget"
        if over
        else f"make cycles: within {budget} and all requirements"
    )
    return bool(over)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
