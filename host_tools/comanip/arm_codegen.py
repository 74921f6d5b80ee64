"""``make arms``: from each firmware/arms/NAME.toml its table in C, and law (4) written out for just this arm.

Run as ``python -m comanip.arm_codegen [FILE...]``; NAME.c and NAME.h are written beside each file, and are committed.

The law is the one of firmware/velocity_control.c, isotropic: errors and the joints' axes may be seen from any frame, as rotations
change neither J^T W J nor J^T W K e. Here it is seen from the frame of one of the arm's joints in the middle, where the axes are
constant or depend on few joints; that joint is chosen for which the fewest operations remain. Joints turn about z.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comanip.straight_line import ONE, ZERO, Block, Term, literal, value

ARMS = Path(__file__).parents[2] / "firmware" / "arms"
Vector = list[Term]
Quaternion = list[Term]
FRAME_KEYS = {"alpha_deg", "a_m", "d_m", "theta_deg", "range_deg"}
ARM_KEYS = {"name", "id", "velocity_max_radps", "margin_deg", "frame"}


class ArmError(ValueError):
    """A line that names the file, the value and what was expected."""


@dataclass(frozen=True)
class Pose:
    """rotation: (4,) unit, w first; matrix: the same, (3, 3); translation_m: (3,)."""

    rotation: np.ndarray
    translation_m: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        w, x, y, z = self.rotation
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        matrix = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        nearest = np.round(matrix)
        return np.where(np.abs(matrix - nearest) < 1e-12, nearest, matrix)

    def __mul__(self, other: Pose) -> Pose:
        return Pose(hamilton(self.rotation, other.rotation), self.translation_m + self.matrix @ other.translation_m)


def hamilton(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def turn(axis: Sequence[float], angle_deg: float) -> np.ndarray:
    half = np.radians(angle_deg) / 2
    return np.concatenate([[np.cos(half)], np.sin(half) * np.array(axis, float)])


@dataclass(frozen=True)
class Arm:
    """twist: from the previous joint's moving frame (the torso for the first) to the joint, but for the offset of its angle;
    effector: from the last to the hand."""

    name: str
    id: int
    title: str
    twist: list[Pose]
    offset_deg: list[float]
    effector: Pose
    range_rad: list[tuple[float, float]]
    velocity_max_radps: float


    @property
    def fixed(self) -> list[Pose]:
        """With the offset, so that the joint only adds its angle."""
        return [twist * about_z(offset) for twist, offset in zip(self.twist, self.offset_deg, strict=True)]


def about_z(angle_deg: float) -> Pose:
    return Pose(turn([0, 0, 1], angle_deg), np.zeros(3))


def modified_dh(frame: dict) -> Pose:
    """Without theta."""
    about_x = Pose(turn([1, 0, 0], frame.get("alpha_deg", 0.0)), np.zeros(3))
    return about_x * Pose(np.array([1.0, 0, 0, 0]), np.array([frame.get("a_m", 0.0), 0.0, frame.get("d_m", 0.0)]))


def read(path: Path) -> Arm:
    """The arm that a file describes; ArmError for what is missing or unknown in it."""
    text = path.read_text()
    try:
        description = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ArmError(f"{path}: {error}") from error
    for place, found, known in [("", description, ARM_KEYS), *(("frame: ", f, FRAME_KEYS) for f in description.get("frame", []))]:
        if unknown := set(found) - known:
            raise ArmError(f"{path}: {place}{min(unknown)}: unknown, expected {', '.join(sorted(known))}")
    if missing := ARM_KEYS - {"margin_deg"} - set(description):
        raise ArmError(f"{path}: {min(missing)} is missing")
    margin = description.get("margin_deg", 0.0)
    twists, offsets, ranges, reached = [], [], [], Pose(np.array([1.0, 0, 0, 0]), np.zeros(3))
    for frame in description["frame"]:
        reached = reached * modified_dh(frame)
        if "range_deg" in frame:
            low, high = frame["range_deg"]
            twists.append(reached)
            offsets.append(frame.get("theta_deg", 0.0))
            ranges.append((np.radians(low + margin), np.radians(high - margin)))
            reached = Pose(np.array([1.0, 0, 0, 0]), np.zeros(3))
        else:
            reached = reached * about_z(frame.get("theta_deg", 0.0))
    if not 1 <= len(twists) <= 8:
        raise ArmError(f"{path}: {len(twists)} joints (frames with a range_deg), expected 1 to 8")
    title = text.splitlines()[0].removeprefix("# ")
    return Arm(description["name"], description["id"], title, twists, offsets, reached, ranges, description["velocity_max_radps"])


# ---- the same formulas for numbers and for what is known at run time only


def constants(numbers: np.ndarray) -> list[Term]:
    return [Term(0.0 if abs(number) < 1e-12 else float(number)) for number in numbers]


def cross(block: Block, a: Vector, b: Vector) -> Vector:
    return [
        block.add(block.multiply(a[i], b[j]), -block.multiply(a[j], b[i]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]


def add(block: Block, a: Vector, b: Vector) -> Vector:
    return [block.add(x, y) for x, y in zip(a, b, strict=True)]


def quaternion_product(block: Block, a: Quaternion, b: Quaternion) -> Quaternion:
    rows = [[(0, 0, 1), (1, 1, -1), (2, 2, -1), (3, 3, -1)], [(0, 1, 1), (1, 0, 1), (2, 3, 1), (3, 2, -1)],
            [(0, 2, 1), (1, 3, -1), (2, 0, 1), (3, 1, 1)], [(0, 3, 1), (1, 2, 1), (2, 1, -1), (3, 0, 1)]]  # fmt: skip
    return [
        block.sum([product if sign > 0 else -product for i, j, sign in row for product in [block.multiply(a[i], b[j])]])
        for row in rows
    ]


def conjugate(q: Quaternion) -> Quaternion:
    return [q[0], -q[1], -q[2], -q[3]]


@dataclass
class Joint:
    """Cosine and sine of the angle, and of half of it."""

    cosine: Term
    sine: Term
    half_cosine: Term
    half_sine: Term

    def turned(self, block: Block, v: Vector, sign: int = 1) -> Vector:
        """Rot_z(angle) v, or with the sign of -1 Rot_z(-angle) v."""
        sine = self.sine if sign > 0 else -self.sine
        x = block.add(block.multiply(self.cosine, v[0]), -block.multiply(sine, v[1]))
        y = block.add(block.multiply(sine, v[0]), block.multiply(self.cosine, v[1]))
        return [x, y, v[2]]

    @property
    def quaternion(self) -> Quaternion:
        return [self.half_cosine, ZERO, ZERO, self.half_sine]


def ahead(block: Block, cosine: Term, sine: Term, angle_deg: float) -> list[Term]:
    """Cosine and sine of the angle that is `angle_deg` further."""
    c, s = constants([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))])
    return [block.add(block.multiply(c, cosine), -block.multiply(s, sine)), block.add(block.multiply(s, cosine), block.multiply(c, sine))]


def rotated(block: Block, matrix: np.ndarray, v: Vector) -> Vector:
    return [block.dot(constants(row), v) for row in matrix]


@dataclass
class Seen:
    """The arm from the frame of joint `middle`: axes (n x 3), the way from each axis to the hand (n x 3), the hand (3), the
    target (3), and the rotation from the hand to the target (4), all in this frame's axes."""

    axes: list[Vector]
    levers: list[Vector]
    hand: Vector
    target: Vector
    turn: Quaternion


def to_middle(block: Block, arm: Arm, joints: list[Joint], middle: int, v: Vector, start: int, is_point: bool) -> Vector:
    """From the moving frame of joint start - 1 (the torso for 0) to the frame of joint `middle`, before that one turns."""
    for i in range(start, middle + 1):
        if is_point:
            v = add(block, v, constants(-arm.twist[i].translation_m))
        v = rotated(block, arm.twist[i].matrix.T, v)
        if i < middle:
            v = joints[i].turned(block, v, -1)
    return v


def see(block: Block, arm: Arm, joints: list[Joint], target: Vector, target_rotation: Quaternion, middle: int, right_first: bool) -> Seen:
    n = len(arm.twist)

    def from_hand_side(v: Vector, end: int, is_point: bool) -> Vector:
        """From the frame of joint `end` (before it turns; the hand for n) to the frame of joint `middle`."""
        for i in range(end, middle, -1):
            pose = arm.twist[i] if i < n else arm.effector
            v = rotated(block, pose.matrix, v)
            if is_point:
                v = add(block, v, constants(pose.translation_m))
            v = joints[i - 1].turned(block, v)
        return v

    def seen(v: Vector, joint: int, is_point: bool) -> Vector:
        """From the frame of a joint before it turns, on either side."""
        if joint >= middle:
            return from_hand_side(v, joint, is_point)
        return to_middle(block, arm, joints, middle, joints[joint].turned(block, v, -1), joint + 1, is_point)

    axes = [seen([ZERO, ZERO, ONE], i, False) for i in range(n)]
    hand = from_hand_side([ZERO, ZERO, ZERO], n, True)
    points = [seen([ZERO, ZERO, ZERO], i, True) for i in range(n)]
    levers = [add(block, hand, [-x for x in point]) for point in points]

    def before(q: Quaternion) -> Quaternion:
        """conj(rotation from the torso to the middle) q."""
        for i in range(middle + 1):
            q = quaternion_product(block, conjugate(constants(arm.twist[i].rotation)), q)
            if i < middle:
                q = quaternion_product(block, conjugate(joints[i].quaternion), q)
        return q

    def after(q: Quaternion) -> Quaternion:
        """q conj(rotation from the middle to the hand)."""
        q = quaternion_product(block, q, conjugate(constants(arm.effector.rotation)))
        for i in range(n - 1, middle - 1, -1):
            q = quaternion_product(block, q, conjugate(joints[i].quaternion))
            if i > middle:
                q = quaternion_product(block, q, conjugate(constants(arm.twist[i].rotation)))
        return q

    rotation = before(after(target_rotation)) if right_first else after(before(target_rotation))
    return Seen(axes, levers, hand, to_middle(block, arm, joints, middle, target, 0, is_point=True), rotation)


# ---- law (4)


def errors(arm: Arm, joints: list[Joint], middle: int, seen: Seen) -> list[str]:
    """What the two error frames differ in: g, and the error's parts with their pulls; see velocity_control_isotropic.c."""
    names = [f"{part}_{axis}" for part in ("offset", "pull_turn", "pull_dual") for axis in "xyz"]
    at_target, in_torso = Block("a"), Block("b")
    half = Term(0.5)
    way = [at_target.whole(at_target.multiply(half, at_target.add(t, -h))) for t, h in zip(seen.target, seen.hand, strict=True)]
    turn = [Term(1.0, f"turn_{axis}") for axis in "xyz"]
    rotation, translation = Term(1.0, "pull_rotation"), Term(1.0, "law->pull_translation")
    results = {at_target: [*way, *(at_target.multiply(rotation, x) for x in turn), *(at_target.multiply(translation, x) for x in way)]}

    torso = to_middle(in_torso, arm, joints, middle, [ZERO] * 3, 0, is_point=True)
    target, hand = ([in_torso.whole(in_torso.multiply(half, in_torso.add(x, -o))) for x, o in zip(p, torso, strict=True)]
                    for p in (seen.target, seen.hand))  # fmt: skip
    side = Term(1.0, "side")
    moved = add(in_torso, [in_torso.multiply(Term(1.0, "turn_w"), x) for x in target], cross(in_torso, target, turn))
    dual = add(in_torso, [in_torso.multiply(side, x) for x in moved], [-x for x in hand])
    scalar = in_torso.multiply(translation, in_torso.multiply(side, -in_torso.dot(target, turn)))
    pull_turn = add(in_torso, [in_torso.multiply(rotation, x) for x in turn], [in_torso.multiply(scalar, -x) for x in hand])
    results[in_torso] = [*(-x for x in hand), *pull_turn, *(in_torso.multiply(translation, x) for x in dual)]

    lines = [f"    float {', '.join(names)};", "    if (config->error_frame == ERROR_FRAME_TARGET) {"]
    for block, end in ((at_target, "    } else {"), (in_torso, "    }")):
        lines += block.text(results[block], " " * 8)
        lines += [f"        {name} = {value(result)};" for name, result in zip(names, results[block], strict=True)]
        lines.append(end)
    return lines


def normal_equations(seen: Seen) -> tuple[list[str], dict[tuple[int, int], Term]]:
    """The normal equations: the lower triangle as matrix_ij, the right-hand side as pull_i."""
    block = Block("n")
    n = len(seen.axes)
    rotation, diagonal = Term(1.0, "law->weight_rotation"), Term(1.0, "law->diagonal")
    offset, turn, dual = ([Term(1.0, f"{part}_{axis}") for axis in "xyz"] for part in ("offset", "pull_turn", "pull_dual"))
    moved: list[list[Term]] = []
    results: dict[str, Term] = {}
    entries: dict[tuple[int, int], Term] = {}
    for i, (axis, lever) in enumerate(zip(seen.axes, seen.levers, strict=True)):
        arm_to_middle = add(block, lever, offset)
        moved.append([block.dot(axis, offset), *cross(block, axis, arm_to_middle)])
        results[f"pull_{i}"] = block.dot([*axis, *moved[i][1:]], [*turn, *dual])
        for j in range(i):
            turned = block.multiply(rotation, block.dot(axis, seen.axes[j]))
            entries[i, j] = block.add(turned, block.dot(moved[i], moved[j]))
        squared = block.dot(moved[i], moved[i])
        results[f"trace_{i}"] = squared
        entries[i, i] = block.add(diagonal, squared)
    named = {f"matrix_{i}{j}": term for (i, j), term in entries.items() if not term.is_zero}
    trace = block.sum(term for name, term in results.items() if name.startswith("trace"))
    pulls = {name: term for name, term in results.items() if name.startswith("pull")}
    lines = block.text([*named.values(), *pulls.values(), trace])
    lines += [f"    if (!({value(trace)} <= law->trace_max)) {{",
              "        velocity_control_general(arm, config, request, velocity_radps);",
              "        return;", "    }"]  # fmt: skip
    lines += [f"    float {name} = {value(term)};" for name, term in {**named, **pulls}.items()]
    lines.append("    if (request->blocked != 0u) {")
    for joint in range(n):
        zeros = [f"matrix_{i}{j}" for (i, j), term in entries.items() if i != j and joint in (i, j) and not term.is_zero]
        lines += [f"        if (request->blocked & {1 << joint}u) {{", f"            {' = '.join([*zeros, f'pull_{joint}'])} = 0.0f;", "        }"]
    lines.append("    }")
    return lines, {place: ZERO if term.is_zero else Term(1.0, f"matrix_{place[0]}{place[1]}") for place, term in entries.items()}


class Solver:
    """L D L^T in blocks of two rows, with the right-hand side carried along: half as many divisions as row by row. What is 0 by
    construction is left out."""

    def __init__(self, n: int, matrix: dict[tuple[int, int], Term]):
        self.lines: list[str] = []
        self._n = n
        self._row = {place: term.variable for place, term in matrix.items()}  # the lower triangle; None: 0
        self._pull = [f"pull_{i}" for i in range(n)]
        self._factor: dict[tuple[int, int], str] = {}
        self._inverse: dict[tuple[int, int], str] = {}  # of the blocks on the diagonal
        self._blocks = [(i,) for i in range(n - 2)] + [tuple(range(max(n - 2, 0), n))]

    def _assign(self, name: str, first: str | None, products: Sequence[tuple[str | None, str | None]], sign: str = "-") -> str | None:
        """first - a b - c d ...; without the products of which a factor is 0."""
        terms = [f"{a} * {b}" for a, b in products if a and b]
        if not terms:
            return first
        start = [first] if first else [terms.pop(0) if sign == "+" else f"-({terms.pop(0)})"]
        self.lines.append(f"    const float {name} = {f' {sign} '.join([*start, *terms])};")
        return name

    def _invert(self, block: tuple[int, ...]) -> None:
        i, j = block[0], block[-1]
        if i == j:
            self.lines.append(f"    const float inverse_{i}{i} = 1.0f / {self._row[i, i]};")
            self._inverse[i, i] = f"inverse_{i}{i}"
            return
        determinant = self._assign(f"determinant_{i}", f"{self._row[i, i]} * {self._row[j, j]}", [(self._row[j, i],) * 2])
        self.lines.append(f"    const float over_{i} = 1.0f / ({determinant});")
        for row, column, entry in ((i, i, self._row[j, j]), (j, i, self._row[j, i]), (j, j, self._row[i, i])):
            self._inverse[row, column] = self._assign(f"inverse_{row}{column}", None, [(entry, f"over_{i}")], "+")

    def _times_inverse(self, name: str, values: dict[int, str | None], block: tuple[int, ...]) -> dict[int, str | None]:
        """A row of two times the block's inverse."""
        if len(block) == 1:
            i = block[0]
            return {i: self._assign(f"{name}{i}", None, [(values[i], self._inverse[i, i])], "+")}
        i, j = block
        mixed = self._inverse[j, i]
        first = self._assign(f"{name}{i}_", None, [(values[i], self._inverse[i, i])], "+")
        second = self._assign(f"{name}{j}_", None, [(values[j], self._inverse[j, j])], "+")
        return {i: self._assign(f"{name}{i}", first, [(values[j], mixed)]), j: self._assign(f"{name}{j}", second, [(values[i], mixed)])}

    def solve(self) -> list[str]:
        for number, block in enumerate(self._blocks):
            for i in block:
                for before in self._blocks[:number]:
                    for k in before:
                        earlier = [j for j in range(before[0]) if (k, j) in self._factor]
                        self._row[i, k] = self._assign(f"row_{i}{k}", self._row[i, k], [(self._row[i, j], self._factor[k, j]) for j in earlier])
                    found = self._times_inverse(f"factor_{i}", {k: self._row[i, k] for k in before}, before)
                    self._factor.update({(i, k): name for k, name in found.items() if name})
                known = [j for j in range(block[0]) if (i, j) in self._factor]
                for k in (k for k in block if k <= i):
                    self._row[i, k] = self._assign(f"pivot_{i}{k}", self._row[i, k], [(self._row[i, j], self._factor.get((k, j))) for j in range(block[0])])
                self._pull[i] = self._assign(f"carried_{i}", self._pull[i], [(self._factor[i, j], self._pull[j]) for j in known]) or ""
            self._invert(block)
        for block in reversed(self._blocks):
            speeds = self._times_inverse("free_", {i: self._pull[i] for i in block}, block)
            for i in block:
                later = [(self._factor.get((k, i)), f"speed_{k}") for k in range(block[-1] + 1, self._n)]
                name = self._assign(f"speed_{i}", speeds[i], later)
                if name != f"speed_{i}":
                    self.lines.append(f"    const float speed_{i} = {name};")
        return self.lines + [f"    velocity_radps[{i}] = speed_{i};" for i in range(self._n)]


def sines_and_cosines(n: int) -> list[str]:
    """sine_cosine_inline() of the half angles, all joints at each step, so that each coefficient is loaded once: the same bits."""
    joints = range(n)
    lines = [f"    const float half_{i} = 0.5f * position_rad[{i}];" for i in joints]
    lines.append(f"    float {', '.join(f'sine_{i}' for i in joints)}, {', '.join(f'cosine_{i}' for i in joints)};")
    lines.append(f"    if ({' && '.join(f'sine_cosine_is_small(half_{i})' for i in joints)}) {{")
    steps = ["const float z_{i} = half_{i} * half_{i};"]
    for name, powers in (("sine", (9, 7, 5, 3)), ("cosine", (10, 8, 6, 4))):
        first, *others = (f"{name.upper()}_{power}" for power in powers)
        steps.append(f"{name}_{{i}} = {first} * z_{{i}};")
        for other in others:
            last = other == others[-1]
            steps.append(f"{name}_{{i}} = {name}_{{i}} + {other};" if last else f"{name}_{{i}} = ({name}_{{i}} + {other}) * z_{{i}};")
    steps.append("sine_{i} = sine_{i} * (z_{i} * half_{i}) + half_{i};")
    steps.append("cosine_{i} = cosine_{i} * (z_{i} * z_{i}) + (1.0f - 0.5f * z_{i});")
    lines += [f"        {step.format(i=i)}" for step in steps for i in joints]
    lines.append("    } else {")
    for i in joints:
        lines.append(f"        const sine_cosine_t both_{i} = sine_cosine(half_{i});")
        lines += [f"        {part}_{i} = both_{i}.{part};" for part in ("sine", "cosine")]
    return [*lines, "    }"]


def law(arm: Arm, middle: int, right_first: bool) -> list[str]:
    n = len(arm.twist)
    lines = ["    const velocity_isotropic_t *const law = &config->isotropic;", "    const float *const position_rad = request->position_rad;",
             "    const pose_t *const target = request->target;"]  # fmt: skip
    lines += sines_and_cosines(n)
    block = Block("m")
    joints = []
    for i in range(n):
        sine, cosine = Term(1.0, f"sine_{i}"), Term(1.0, f"cosine_{i}")
        twice = block.whole(block.add(sine, sine))
        full = (block.add(ONE, -block.multiply(twice, sine)), block.multiply(twice, cosine))
        joints.append(Joint(*ahead(block, *full, arm.offset_deg[i]), *ahead(block, cosine, sine, arm.offset_deg[i] / 2)))
    target = [Term(1.0, f"target->translation_m.{axis}") for axis in "xyz"]
    rotation = [Term(1.0, f"target->rotation.{axis}") for axis in "wxyz"]
    seen = see(block, arm, joints, target, rotation, middle, right_first)
    scale = abs(seen.turn[0].factor)  # the rotation's, taken out where all its parts have the same
    turn = [block.whole(Term(term.factor / scale, term.variable)) for term in seen.turn]
    lines += block.text([x for v in (*seen.axes, *seen.levers, seen.hand, seen.target, turn) for x in v])
    lines += [f"    const float turn_{axis} = {value(term)};" for axis, term in zip("wxyz", turn, strict=True)]
    lines.append("    /* target and -target are the same pose: the nearer one */")
    lines.append(f"    const float side = turn_w < 0.0f ? -{literal(scale)} : {literal(scale)};")
    lines.append("    const float pull_rotation = side * law->pull_rotation;")
    equations, matrix = normal_equations(seen)
    return [*lines, *errors(arm, joints, middle, seen), *equations, *Solver(n, matrix).solve()]


def fewest_operations(arm: Arm) -> list[str]:
    ways = [law(arm, middle, right_first) for middle in range(len(arm.twist)) for right_first in (False, True)]
    return min(ways, key=lambda lines: sum(line.count(sign) for line in lines for sign in (" + ", " - ", " * ", " / ")))


# ---- the files


def numbers(values: Sequence[float]) -> str:
    return ", ".join(literal(0.0 if abs(x) < 1e-12 else x) for x in values)


def pose(p: Pose) -> str:
    return f"{{{{{numbers(p.rotation)}}}, {{{numbers(p.translation_m)}}}}}"


def source(arm: Arm, origin: str) -> str:
    rows = [
        f"    {{{pose(fixed)}, {{0.0f, 0.0f, 1.0f}}, {numbers([*limits, arm.velocity_max_radps])}}},"
        for fixed, limits in zip(arm.fixed, arm.range_rad, strict=True)
    ]
    return "\n".join([
        f"/* Made by `make arms` from {origin}: edit that. How: host_tools/comanip/arm_codegen.py. */",
        f'#include "{arm.name}.h"', "", '#include "../trigonometry_inline.h"', '#include "../velocity_control.h"',
        '#include "../velocity_control_general.h"', "",
        f"static const arm_joint_t joints[{len(rows)}] = {{", *rows, "};", "",
        "/* velocity_control_isotropic() for this arm. */",
        "static void isotropic(const arm_t *arm, const velocity_control_config_t *config, const velocity_request_t *request,",
        "                      float velocity_radps[]) {",
        *fewest_operations(arm), "}", "",
        f"const arm_t arm_{arm.name} = {{",
        f'    .name = "{arm.name}",', f"    .id = {arm.id},", f"    .joint_count = {len(rows)},", "    .joints = joints,",
        f"    .effector = {pose(arm.effector)},", "    .isotropic = isotropic,", "};", "",
    ])  # fmt: skip


def header(arm: Arm, origin: str) -> str:
    guard = f"COMANIP_ARMS_{arm.name.upper()}_H"
    return "\n".join([
        f"/* {arm.title} */", f"/* Made by `make arms` from {origin}: edit that. */", f"#ifndef {guard}", f"#define {guard}", "",
        '#include "../arm.h"', "", f"extern const arm_t arm_{arm.name};", "", "#endif", "",
    ])  # fmt: skip


def main(argv: Sequence[str]) -> int:
    for path in [Path(argument) for argument in argv] or sorted(ARMS.glob("*.toml")):
        try:
            arm = read(path)
        except (ArmError, OSError) as error:
            print(f"make arms: {error}", file=sys.stderr)
            return 2
        path.with_suffix(".c").write_text(source(arm, path.name))
        path.with_suffix(".h").write_text(header(arm, path.name))
        print(f"comanip: {path.with_suffix('.c')}, {path.with_suffix('.h')}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
