"""``make bench``: compares the duration of our control tick with the same tick computed by Pinocchio, Orocos KDL,
MuJoCo and dqrobotics, and measures the simulator's speed.

``bench.py BUILD``. A tick consists of Algorithm 1's loop body, the kinematics, the Jacobian and the control law (4);
see contender.hpp. First, the joint velocities of all contenders with control law (4) are checked against the paper's
equations in double precision (dqrobotics, numpy). Then the contenders run in turn for a number of rounds. Each
contender integrates its joint velocities and starts its next tick from the resulting angles. The table shows the median
and the 10th and 90th percentiles of each contender's times. callgrind counts the instructions of two runs of different
length; their difference, divided by the additional ticks, gives the instructions per tick. Prints a table, plots
BUILD/reports/bench.png and writes BUILD/reports/bench.json. The exit status is 1 if contenders disagree, if our tick
allocates from the heap, or if a required ratio is missed. Timings on the host do not apply to a microcontroller.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from rich.console import Console
from rich.table import Table

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
sys.path.insert(0, str(HERE.parent))

import oracle  # noqa: E402
import simulator_speed  # noqa: E402
from comanip_dev.arms import description as arm_description  # noqa: E402
from dqrobotics import DQ  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ARMS = {
    4: REPOSITORY / "firmware" / "arms" / "hoap3_right.toml",
    6: HERE / "arms" / "six.toml",
    7: HERE / "arms" / "seven.toml",
}
START_RAD = {4: [0.3, -0.4, 0.2, -1.2], 6: [0.4, -1.2, 1.5, -0.8, 1.2, 0.3], 7: [0.1, -0.4, 0.2, -1.9, 0.1, 1.6, 0.5]}
GAIN, WEIGHT, DAMPING = 35.0, (0.01, 100.0), 0.01  # the firmware's defaults
HANDS, STATES, ROUNDS, TICKS = 1000, 300, 25, 20_000
CALLGRIND_TICKS = 1000
DQROBOTICS_TICKS = 200
OURS = ("comanip, specialised", "comanip, table")
OWN_LAW = "KDL, wdls"
REQUIRED = {"Pinocchio, double": 5.0, "KDL, wdls": 20.0}  # least ratio of the contender's time to ours
WORK = """All contenders get the same inputs, compute Algorithm 1 and control law (4) as (J^T W J + lambda I)^-1
J^T W K e with the default K, W and lambda, and are compiled with -march=x86-64-v3. They differ as follows:
- comanip uses float32 and is compiled as in the product (-O2, -ffp-contract=off). The peers use double (Pinocchio also
  float) and -O3. "comanip, table" reads the arm's table at run time, as the peers read their models; "comanip,
  specialised" is the C code that `make arms` generates for one arm.
- Pinocchio, KDL and MuJoCo compute their 6 x n Jacobian; control law (4) on top of it is written in Eigen, with n known
  at compile time.
- KDL's wdls applies its own control law to the twist, by SVD. It aborts below 6 joints, so n = 4 has two extra locked
  joints.
- MuJoCo also computes the centres of mass of the bodies, which its Jacobian needs.
- dqrobotics is called from Python, and numpy solves the linear system. The time of the calls alone is printed below
  each table.
- KDL and MuJoCo are the libraries shipped by Debian and PyPI; Pinocchio's templates are compiled here."""


@dataclass
class Case:
    """An arm, and the inputs of its ticks. model: the file from which the benchmark program reads them."""

    n: int
    arm: arm_description.Arm
    hands: np.ndarray  # (HANDS, 8) poses
    states: np.ndarray  # (STATES, n)
    algorithm: oracle.Algorithm1
    model: Path


# ---- inputs


def kinematics(arm: arm_description.Arm, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns pose (8,) and Jacobian (8, n) of the end effector, computed from the joint poses in double precision."""
    left = [oracle.pose([1.0, 0, 0, 0], np.zeros(3))]
    for fixed, angle in zip(arm.fixed, q, strict=True):
        joint = oracle.multiply(left[-1], oracle.pose(fixed.rotation, fixed.translation_m))
        left.append(oracle.multiply(joint, oracle.pose(oracle.rotation([0, 0, 1], angle), np.zeros(3))))
    hand = oracle.multiply(left[-1], oracle.pose(arm.effector.rotation, arm.effector.translation_m))
    axis = np.array([0, 0, 0, 0.5, 0, 0, 0, 0])
    columns = [oracle.multiply(oracle.multiply(oracle.multiply(x, axis), oracle.conjugate(x)), hand) for x in left[1:]]
    return hand, np.stack(columns, axis=1)


def single(values: np.ndarray) -> np.ndarray:
    """Rounds to float32, so that all contenders get the same input.

    Rotations must not be rounded: in float32 their norm is no longer exactly 1, which the peers handle in different
    ways.
    """
    return np.asarray(values, np.float32).astype(float)


def row(rotation: np.ndarray, translation: np.ndarray) -> str:
    return " ".join(f"{value:.17g}" for value in [*rotation, *translation])


def make_case(n: int, folder: Path, rng: np.random.Generator) -> Case:
    arm = arm_description.read(ARMS[n])
    turn = 2 * np.pi * np.arange(HANDS) / HANDS  # the hand goes round its closed path once a second
    rotations = oracle.rotation(np.stack([np.sin(turn), np.cos(turn), 0 * turn + 0.5], axis=1), 0.4 * np.sin(2 * turn))
    places = single(
        np.stack([0.06 * np.sin(turn), 0.05 * np.sin(2 * turn), 0.04 - 0.04 * np.cos(turn)], axis=1) + [0.4, -0.2, 0.9]
    )
    start = single(np.array(START_RAD[n]))
    robot, _ = kinematics(arm, start)
    hands = oracle.pose(rotations, places)
    algorithm = oracle.Algorithm1("pour", oracle.unit(hands[0]), oracle.unit(robot), np.array([1.0, 0, 0, 0]))
    t_task, q_task, q_inv = oracle.TABLE_I["pour"]
    right = oracle.quaternion_multiply(
        oracle.quaternion_multiply(
            oracle.quaternion_conjugate(rotations[0]), oracle.quaternion_multiply(robot[:4], q_inv)
        ),
        oracle.quaternion_conjugate(q_task),
    )
    states = single(start + rng.uniform(-0.3, 0.3, (STATES, n)))
    lines = [f"{arm.name} {n} {HANDS} {STATES}"]
    lines += [row(fixed.rotation, fixed.translation_m) for fixed in [*arm.fixed, arm.effector]]
    lines += [row([1, 0, 0, 0], places[0]), row(right, oracle.translation(robot)), row(t_task, [])]
    lines += [row([*WEIGHT, GAIN, GAIN, DAMPING], []), row(start, [])]
    lines += [row(r, t) for r, t in zip(rotations, places, strict=True)] + [row(q, []) for q in states]
    model = folder / f"{arm.name}.txt"
    model.write_text("\n".join(lines) + "\n")
    return Case(n, arm, hands, states, algorithm, model)


def law_in_double(case: Case) -> np.ndarray:
    """Returns the joint velocities (STATES, n) according to the paper's equations."""
    targets = np.array([case.algorithm.target(oracle.unit(hand)) for hand in case.hands[:STATES]])
    poses, jacobians = zip(*(kinematics(case.arm, q) for q in case.states), strict=True)
    weight = np.repeat(WEIGHT, 4)
    return oracle.law(np.array(jacobians), np.array(poses), targets, GAIN, weight, DAMPING, "target")


# ---- the program


def run(command: list[object]) -> str:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(
            f"make bench: {' '.join(map(str, command[:3]))} ...: exit status {done.returncode}\n{done.stderr[-3000:]}"
        )
    return done.stdout


def rows(output: str) -> dict[str, list[list[float]]]:
    """Returns the numbers in the program's output lines, grouped by contender."""
    found: dict[str, list[list[float]]] = {}
    for line in output.splitlines():
        name, *values = line.split("\t")
        found.setdefault(name, []).append([float(value) for value in values])
    return found


def disagreements(case: Case, program: Path) -> tuple[dict[str, float], list[str]]:
    """Returns the largest difference of each contender from the equations in double precision, relative to
    max(1, |u|, K / 10), and a complaint for each difference above the bound. OWN_LAW has no bound,
    because it applies a different law."""
    expected = law_in_double(case)
    scale = np.maximum(np.maximum(1.0, GAIN / 10), np.linalg.norm(expected, axis=1, keepdims=True))
    found, complaints = {}, []
    peer = Dqrobotics(case)
    answers = rows(run([program, case.model, "check"]))
    answers[peer.name] = [list(peer.velocity(q, hand)) for q, hand in zip(case.states, peer.hands)]
    for name, values in answers.items():
        found[name] = float((np.abs(np.array(values) - expected) / scale).max())
        single_precision = name in OURS or name.endswith("float")  # bound of tests/test_differential_ik.py
        bound = max(5e-5, 5e-8 * max(4, *WEIGHT) / DAMPING) if single_precision else 1e-9
        if name != OWN_LAW and not found[name] <= bound:
            complaints.append(
                f"n = {case.n}: {name} differs by {found[name]:.2g} from the equations, bound {bound:.2g}"
            )
    return found, complaints


def instructions(case: Case, program: Path, name: str) -> float:
    """Returns the instructions per tick, from callgrind's counts of two runs that differ by CALLGRIND_TICKS ticks."""
    counts = []
    for ticks in (CALLGRIND_TICKS, 2 * CALLGRIND_TICKS):
        out = case.model.with_suffix(f".{name.replace(' ', '').replace(',', '-')}.{ticks}")
        run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, case.model, "run", ticks, name])
        counts.append(
            int(next(line for line in out.read_text().splitlines() if line.startswith("summary:")).split()[1])
        )
    return (counts[1] - counts[0]) / CALLGRIND_TICKS


# ---- dqrobotics, from Python


class Dqrobotics:
    """The tick that the other contenders compute, written with dqrobotics' DQ and with n x n matrices in numpy."""

    name = "dqrobotics, from Python"

    def __init__(self, case: Case):
        self.algorithm, self.n = case.algorithm, case.n
        t_task, q_task, _ = oracle.TABLE_I["pour"]
        self.relation = DQ(oracle.pose(q_task, t_task))
        self.fixed = [DQ(oracle.pose(fixed.rotation, fixed.translation_m)) for fixed in case.arm.fixed]
        self.effector = DQ(oracle.pose(case.arm.effector.rotation, case.arm.effector.translation_m))
        self.axis = DQ([0, 0, 0, 0.5, 0, 0, 0, 0])
        self.hands = [DQ(oracle.unit(hand)) for hand in case.hands]
        self.weight = np.repeat(WEIGHT, 4)
        self.calls = 11 + 9 * case.n  # library calls per tick

    def velocity(self, q: np.ndarray, hand: DQ) -> np.ndarray:
        motion = self.algorithm.hand_start.conj() * hand
        virtual = self.algorithm.hand_start_torso * oracle.dqrobotics.dec_mult(self.algorithm.virtual_start, motion)
        target = virtual * self.relation.conj()
        pose, moving = DQ([1]), []
        for fixed, angle in zip(self.fixed, q, strict=True):
            pose = pose * fixed * DQ([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
            moving.append(pose)
        pose = pose * self.effector
        back = target.conj()
        relative = (back * pose).vec8()
        sign = -1.0 if relative[0] < 0 else 1.0
        jacobian = np.stack([sign * (back * (x * self.axis * x.conj()) * pose).vec8() for x in moving], axis=1)
        error = -sign * relative
        error[0] += 1
        weighted = jacobian.T * self.weight
        return np.linalg.solve(weighted @ jacobian + DAMPING * np.eye(self.n), weighted @ (GAIN * error))

    def time_ns(self, start: np.ndarray, ticks: int) -> float:
        q = start.copy()
        begin_ns = time.perf_counter_ns()
        for k in range(ticks):
            q += 1e-3 * self.velocity(q, self.hands[k % HANDS])
        return (time.perf_counter_ns() - begin_ns) / ticks

    def call_ns(self, calls: int = 20_000) -> float:
        """Returns the duration of a library call with almost no computation, which is the overhead of Python and the
        binding per call."""
        begin_ns = time.perf_counter_ns()
        for _ in range(calls):
            self.axis.conj()
        return (time.perf_counter_ns() - begin_ns) / calls


# ---- the run


def times_ours(times: dict[str, list[float]], name: str) -> float:
    """Returns the median ratio to our time. Each ratio is formed within one round, because a disturbance during a round
    affects both times."""
    return float(np.median(np.array(times[name]) / np.array(times[OURS[0]])))


def summary(values: list[float]) -> dict[str, float]:
    low, median, high = np.percentile(values, [10, 50, 90])
    return {"median": float(median), "percentile_10": float(low), "percentile_90": float(high)}


def measure(case: Case, program: Path) -> dict[str, dict]:
    """Measures the time [ns], the heap allocations and the instructions per tick of each contender."""
    peer = Dqrobotics(case)
    times: dict[str, list[float]] = {}
    heap: dict[str, float] = {}
    for _ in range(ROUNDS):
        for name, ((ns, allocations),) in rows(run([program, case.model, "time", TICKS])).items():
            times.setdefault(name, []).append(ns)
            heap[name] = max(heap.get(name, 0.0), allocations)
        times.setdefault(peer.name, []).append(peer.time_ns(np.array(START_RAD[case.n]), DQROBOTICS_TICKS))
    found = {name: {"ns": summary(values), "times_ours": times_ours(times, name), "heap_allocations": heap.get(name)}
             for name, values in times.items()}  # fmt: skip
    for name, figures in found.items():
        figures["instructions"] = None if name == peer.name else instructions(case, program, name)
    found[peer.name]["calls_overhead_ns"] = peer.calls * peer.call_ns()
    return found


def missed(n: int, found: dict[str, dict]) -> list[str]:
    """Returns a complaint for each contender whose ratio to our time is below the required value, and for each of our
    contenders that allocates from the heap."""
    complaints = []
    for name, required in REQUIRED.items():
        ratio = found[name]["times_ours"]
        if ratio < required:
            complaints.append(f"n = {n}: {name} takes {ratio:.1f} times as long as ours, required {required:g}")
    complaints += [
        f"n = {n}: {name}: {found[name]['heap_allocations']:g} heap allocations per tick"
        for name in OURS
        if found[name]["heap_allocations"]
    ]
    return complaints


# ---- output


def show(results: dict[int, dict[str, dict]], console: Console) -> None:
    for n, found in results.items():
        table = Table(title=f"One tick, n = {n}", title_justify="left")
        for header in ("contender", "ns (10 % .. 90 %)", "times ours", "instructions", "heap", "from double"):
            table.add_column(header, justify="left" if header == "contender" else "right")
        for name, figures in sorted(found.items(), key=lambda item: item[1]["ns"]["median"]):
            ns = figures["ns"]
            cell = f"{ns['median']:.0f} ({ns['percentile_10']:.0f} .. {ns['percentile_90']:.0f})"
            instructions_cell = "-" if figures["instructions"] is None else f"{figures['instructions']:.0f}"
            heap_cell = "-" if figures["heap_allocations"] is None else f"{figures['heap_allocations']:g}"
            table.add_row(
                name,
                cell,
                f"{figures['times_ours']:.1f}",
                instructions_cell,
                heap_cell,
                f"{figures['from_double']:.1g}",
            )
        console.print(table)
        overhead = found[Dqrobotics.name]["calls_overhead_ns"]
        print(f"About {overhead:.0f} ns of dqrobotics' time is the overhead of the calls from Python.\n")
    print(WORK)


def draw(results: dict[int, dict[str, dict]], path: Path) -> None:
    figure, axes = plt.subplots(figsize=(9, 4.5), layout="constrained")
    names = sorted(results[4], key=lambda name: results[4][name]["ns"]["median"])
    for place, (n, found) in enumerate(results.items()):
        medians = [found[name]["ns"]["median"] for name in names]
        spread = [[m - found[name]["ns"]["percentile_10"] for m, name in zip(medians, names)],
                  [found[name]["ns"]["percentile_90"] - m for m, name in zip(medians, names)]]  # fmt: skip
        axes.barh(
            np.arange(len(names)) + 0.27 * (place - 1), medians, 0.25, xerr=np.maximum(spread, 0), label=f"n = {n}"
        )
    axes.set_xscale("log")
    axes.set_yticks(range(len(names)), names)
    axes.grid(axis="x", alpha=0.3)
    axes.set_axisbelow(True)
    axes.set_title("Algorithm 1, kinematics and control law (4): our tick compared with its peers")
    axes.invert_yaxis()
    axes.set_xlabel("one tick on this machine [ns], median, 10th to 90th percentile")
    axes.legend()
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main(argv: list[str]) -> int:
    build = Path(argv[0]).resolve()
    folder, reports = build / "bench", build / "reports"
    reports.mkdir(parents=True, exist_ok=True)
    program = folder / "ticks"
    cases = [make_case(n, folder, np.random.default_rng(n)) for n in ARMS]
    differences, complaints = {}, []
    for case in cases:
        differences[case.n], beyond = disagreements(case, program)
        complaints += beyond
    if complaints:  # times are comparable only if all contenders compute the same
        print("\n".join(f"make bench: {line}" for line in complaints), file=sys.stderr)
        return 1
    results = {case.n: measure(case, program) for case in cases}
    for case in cases:
        for name, figures in results[case.n].items():
            figures["from_double"] = differences[case.n][name]
        complaints += missed(case.n, results[case.n])
    show(results, Console(width=120))
    draw(results, reports / "bench.png")
    speeds, slow = simulator_speed.measure()
    report = {"ticks": {f"n_{n}": found for n, found in results.items()}, "simulated_over_wall_time": speeds}
    (reports / "bench.json").write_text(json.dumps(report, indent=1) + "\n")
    for line in complaints:
        print(f"make bench: {line}", file=sys.stderr)
    return bool(complaints) or slow


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
