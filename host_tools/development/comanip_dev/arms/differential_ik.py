"""Generates differential inverse kinematics (equation (4)) and forward kinematics of one arm, as lines of C functions.

The equations are those of firmware/control/differential_ik_isotropic.c. Errors and joint axes may be expressed in any
frame, because a rotation of the frame changes neither J^T W J nor J^T W K e. Here they are expressed in the frame of a
joint in the middle of the arm, where the axes are constant or depend on few joints. The generator tries every joint as
the middle joint and keeps the code with the fewest operations. All joints turn about the z axes of their frames.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from comanip_dev.arms.description import Arm
from comanip_dev.arms.straight_line import ONE, ZERO, Block, Term, Vector, literal, operations, value

Quaternion = list[Term]
COLUMNS = 120


# ---- formulas that consist of Terms (see straight_line.py)


def constants(numbers: np.ndarray) -> list[Term]:
    return [Term(0.0 if abs(number) < 1e-12 else float(number)) for number in numbers]


def cross(block: Block, a: Vector, b: Vector) -> Vector:
    return [block.add(block.multiply(a[i], b[j]), -block.multiply(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]


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
    """The cosine and sine of a joint's angle and of half the angle."""

    cosine: Term
    sine: Term
    half_cosine: Term
    half_sine: Term

    def turned(self, block: Block, v: Vector, sign: int = 1) -> Vector:
        """Returns Rot_z(angle) v, or Rot_z(-angle) v if sign is -1."""
        sine = self.sine if sign > 0 else -self.sine
        x = block.add(block.multiply(self.cosine, v[0]), -block.multiply(sine, v[1]))
        y = block.add(block.multiply(sine, v[0]), block.multiply(self.cosine, v[1]))
        return [x, y, v[2]]

    @property
    def quaternion(self) -> Quaternion:
        return [self.half_cosine, ZERO, ZERO, self.half_sine]


def joints_of(block: Block, arm: Arm, sines: list[str], cosines: list[str]) -> list[Joint]:
    """Returns the joints. sines, cosines: names of the C variables for the sine and cosine of half the measured angle,
    without the joint's offset."""
    joints = []
    for offset_deg, sine, cosine in zip(
        arm.offset_deg, (Term(1.0, s) for s in sines), (Term(1.0, c) for c in cosines), strict=True
    ):
        twice = block.whole(block.add(sine, sine))
        full = (block.add(ONE, -block.multiply(twice, sine)), block.multiply(twice, cosine))
        joints.append(Joint(*ahead(block, *full, offset_deg), *ahead(block, cosine, sine, offset_deg / 2)))
    return joints


def ahead(block: Block, cosine: Term, sine: Term, angle_deg: float) -> list[Term]:
    """Returns the cosine and sine of a + `angle_deg`. cosine, sine: cosine and sine of the angle a."""
    c, s = constants([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))])
    return [
        block.add(block.multiply(c, cosine), -block.multiply(s, sine)),
        block.add(block.multiply(s, cosine), block.multiply(c, sine)),
    ]


def rotated(block: Block, matrix: np.ndarray, v: Vector) -> Vector:
    return [block.dot(constants(row), v) for row in matrix]


@dataclass
class Seen:
    """The arm expressed in the frame of joint `middle`: joint axes (n x 3), levers from each axis to the end effector
    (n x 3), positions of the end effector (3) and of the target (3), and the rotation from the end effector to the
    target (4)."""

    axes: list[Vector]
    levers: list[Vector]
    hand: Vector
    target: Vector
    turn: Quaternion


def to_middle(
    block: Block, arm: Arm, joints: list[Joint], middle: int, v: Vector, start: int, is_point: bool
) -> Vector:
    """Transforms v to the fixed frame of joint `middle`, from the moving frame of joint start - 1 (of the torso if
    start is 0)."""
    for i in range(start, middle + 1):
        if is_point:
            v = add(block, v, constants(-arm.twist[i].translation_m))
        v = rotated(block, arm.twist[i].matrix.T, v)
        if i < middle:
            v = joints[i].turned(block, v, -1)
    return v


def see(
    block: Block,
    arm: Arm,
    joints: list[Joint],
    target: Vector,
    target_rotation: Quaternion,
    middle: int,
    right_first: bool,
) -> Seen:
    n = len(arm.twist)

    def from_hand_side(v: Vector, end: int, is_point: bool) -> Vector:
        """Transforms v from the fixed frame of joint `end` (for n: the end effector) to the fixed frame of joint
        `middle`."""
        for i in range(end, middle, -1):
            pose = arm.twist[i] if i < n else arm.effector
            v = rotated(block, pose.matrix, v)
            if is_point:
                v = add(block, v, constants(pose.translation_m))
            v = joints[i - 1].turned(block, v)
        return v

    def seen(v: Vector, joint: int, is_point: bool) -> Vector:
        """Transforms v from the fixed frame of `joint`, on either side of `middle`, to the fixed frame of `middle`."""
        if joint >= middle:
            return from_hand_side(v, joint, is_point)
        return to_middle(block, arm, joints, middle, joints[joint].turned(block, v, -1), joint + 1, is_point)

    axes = [seen([ZERO, ZERO, ONE], i, False) for i in range(n)]
    hand = from_hand_side([ZERO, ZERO, ZERO], n, True)
    points = [seen([ZERO, ZERO, ZERO], i, True) for i in range(n)]
    levers = [add(block, hand, [-x for x in point]) for point in points]

    def before(q: Quaternion) -> Quaternion:
        """Returns conj(r) q, where r is the rotation from the torso to the middle joint."""
        for i in range(middle + 1):
            q = quaternion_product(block, conjugate(constants(arm.twist[i].rotation)), q)
            if i < middle:
                q = quaternion_product(block, conjugate(joints[i].quaternion), q)
        return q

    def after(q: Quaternion) -> Quaternion:
        """Returns q conj(r), where r is the rotation from the middle joint to the end effector."""
        q = quaternion_product(block, q, conjugate(constants(arm.effector.rotation)))
        for i in range(n - 1, middle - 1, -1):
            q = quaternion_product(block, q, conjugate(joints[i].quaternion))
            if i > middle:
                q = quaternion_product(block, q, conjugate(constants(arm.twist[i].rotation)))
        return q

    rotation = before(after(target_rotation)) if right_first else after(before(target_rotation))
    return Seen(axes, levers, hand, to_middle(block, arm, joints, middle, target, 0, is_point=True), rotation)


# ---- differential inverse kinematics, equation (4)


def errors(arm: Arm, joints: list[Joint], middle: int, seen: Seen, equations: list[str]) -> list[str]:
    """Generates the quantities that depend on the error frame: g (offset_*) and the weighted parts of the error
    (pull_*); see differential_ik_isotropic.c. Leaves out quantities that the equations do not use, as happens for arms
    with few joints."""
    names = [f"{part}_{axis}" for part in ("offset", "pull_turn", "pull_dual") for axis in "xyz"]
    at_target, in_torso = Block("a"), Block("b")
    half = Term(0.5)
    way = [
        at_target.whole(at_target.multiply(half, at_target.add(t, -h)))
        for t, h in zip(seen.target, seen.hand, strict=True)
    ]
    turn = [Term(1.0, f"turn_{axis}") for axis in "xyz"]
    rotation, translation = Term(1.0, "pull_rotation"), Term(1.0, "law->pull_translation")
    results = {
        at_target: [
            *way,
            *(at_target.multiply(rotation, x) for x in turn),
            *(at_target.multiply(translation, x) for x in way),
        ]
    }

    torso = to_middle(in_torso, arm, joints, middle, [ZERO] * 3, 0, is_point=True)
    target, hand = (
        [in_torso.whole(in_torso.multiply(half, in_torso.add(x, -o))) for x, o in zip(p, torso, strict=True)]
        for p in (seen.target, seen.hand)
    )
    side = Term(1.0, "side")
    moved = add(in_torso, [in_torso.multiply(Term(1.0, "turn_w"), x) for x in target], cross(in_torso, target, turn))
    dual = add(in_torso, [in_torso.multiply(side, x) for x in moved], [-x for x in hand])
    scalar = in_torso.multiply(translation, in_torso.multiply(side, -in_torso.dot(target, turn)))
    pull_turn = add(
        in_torso, [in_torso.multiply(rotation, x) for x in turn], [in_torso.multiply(scalar, -x) for x in hand]
    )
    results[in_torso] = [*(-x for x in hand), *pull_turn, *(in_torso.multiply(translation, x) for x in dual)]

    text = "\n".join(equations)
    used = [name in text for name in names]
    names = list(compress(names, used))
    results = {block: list(compress(values, used)) for block, values in results.items()}
    lines = [f"    float {', '.join(names)};", "    if (config->error_frame == ERROR_FRAME_TARGET) {"]
    for block, end in ((at_target, "    } else {"), (in_torso, "    }")):
        lines += block.text(results[block], " " * 8)
        lines += [f"        {name} = {value(result)};" for name, result in zip(names, results[block], strict=True)]
        lines.append(end)
    return lines


def normal_equations(seen: Seen) -> tuple[list[str], dict[tuple[int, int], Term]]:
    """Returns the code that computes the normal equations, and the entries of the lower triangle of their matrix. In
    the code, these entries have the names matrix_ij, and the right-hand side has the names right_i."""
    block = Block("n")
    rotation, diagonal = Term(1.0, "law->weight_rotation"), Term(1.0, "law->diagonal")
    offset, turn, dual = (
        [Term(1.0, f"{part}_{axis}") for axis in "xyz"] for part in ("offset", "pull_turn", "pull_dual")
    )
    moved: list[list[Term]] = []
    results: dict[str, Term] = {}
    entries: dict[tuple[int, int], Term] = {}
    for i, (axis, lever) in enumerate(zip(seen.axes, seen.levers, strict=True)):
        arm_to_middle = add(block, lever, offset)
        moved.append([block.dot(axis, offset), *cross(block, axis, arm_to_middle)])
        results[f"right_{i}"] = block.dot([*axis, *moved[i][1:]], [*turn, *dual])
        for j in range(i):
            turned = block.multiply(rotation, block.dot(axis, seen.axes[j]))
            entries[i, j] = block.add(turned, block.dot(moved[i], moved[j]))
        squared = block.dot(moved[i], moved[i])
        results[f"trace_{i}"] = squared
        entries[i, i] = block.add(diagonal, squared)
    named = {f"matrix_{i}{j}": term for (i, j), term in entries.items() if not term.is_zero}
    trace = block.sum(term for name, term in results.items() if name.startswith("trace"))
    pulls = {name: term for name, term in results.items() if name.startswith("right")}
    lines = block.text([*named.values(), *pulls.values(), trace])
    lines += [f"    if (!({value(trace)} <= law->trace_max)) {{",
              "        differential_ik_general(arm, config, request, velocity_radps);",
              "        return;", "    }"]  # fmt: skip
    lines += [f"    const float {name} = {value(term)};" for name, term in {**named, **pulls}.items()]
    return lines, {
        place: ZERO if term.is_zero else Term(1.0, f"matrix_{place[0]}{place[1]}") for place, term in entries.items()
    }


def assign(
    lines: list[str], name: str, first: str | None, products: Sequence[tuple[str | None, str | None]]
) -> str | None:
    """Adds a line that assigns first - a b - c d ... to a new variable, and returns the variable's name. Leaves out
    products that are 0. If no products are left, adds no line and returns `first`."""
    terms = [f"{a} * {b}" for a, b in products if a and b]
    if not terms:
        return first
    start = [first] if first else [f"-({terms.pop(0)})"]
    lines.append(f"    const float {name} = {' - '.join([*start, *terms])};")
    return name


@dataclass
class Factors:
    """The factorisation L D L^T of the matrix of the normal equations, row by row. None stands for an entry that is 0
    by construction. The last two rows form one block, whose inverse needs one division instead of two. A block of two
    earlier rows would be less accurate."""

    n: int
    eliminated: int  # number of rows before the last two
    row: dict[tuple[int, int], str | None]  # initially the lower triangle, later L D below the diagonal
    factor: dict[tuple[int, int], str | None]
    lines: list[str]


def factorise(n: int, matrix: dict[tuple[int, int], Term], inverse: str = "1.0f / {}") -> Factors:
    lines: list[str] = []
    row = {place: term.variable for place, term in matrix.items()}
    factor: dict[tuple[int, int], str | None] = {}
    eliminated = max(n - 2, 0)
    for i in range(n):
        before = range(min(i, eliminated))
        for j in before:
            row[i, j] = assign(lines, f"row_{i}{j}", row[i, j], [(row[i, k], factor[j, k]) for k in range(j)])
            factor[i, j] = f"factor_{i}{j}" if row[i, j] else None
            if row[i, j]:
                lines.append(f"    const float factor_{i}{j} = {row[i, j]} * inverse_{j};")
        for j in range(eliminated, i):
            row[i, j] = assign(lines, f"row_{i}{j}", row[i, j], [(row[i, k], factor[j, k]) for k in before])
        row[i, i] = assign(lines, f"pivot_{i}", row[i, i], [(row[i, k], factor[i, k]) for k in before])
        if i < eliminated or n == 1:
            lines.append(f"    const float inverse_{i} = {inverse.format(row[i, i])};")
    if n > 1:
        across = row[n - 1, n - 2]
        determinant = assign(lines, "determinant", f"{row[n - 2, n - 2]} * {row[n - 1, n - 1]}", [(across, across)])
        lines.append(f"    const float over = {inverse.format(f'({determinant})')};")
    return Factors(n, eliminated, row, factor, lines)


def substitute(factors: Factors, pulls: str, speeds: str) -> list[str]:
    """Generates code that solves the equations and stores the solution in the array `speeds`. The right-hand side is in
    the variables {pulls}_0, {pulls}_1, ... The names of intermediate variables also begin with `pulls`."""
    lines: list[str] = []
    n, row, factor, eliminated = factors.n, factors.row, factors.factor, factors.eliminated
    pull = [f"{pulls}_{i}" for i in range(n)]
    speed = [f"{pulls}_speed_{i}" for i in range(n)]
    for i in range(n):
        pull[i] = (
            assign(lines, f"{pulls}_carried_{i}", pull[i], [(factor[i, k], pull[k]) for k in range(min(i, eliminated))])
            or pull[i]
        )
    if n == 1:
        lines.append(f"    const float {speed[0]} = {pull[0]} * inverse_0;")
    else:
        across = row[n - 1, n - 2]
        for i, other in ((n - 2, n - 1), (n - 1, n - 2)):
            scaled = assign(lines, f"{pulls}_scaled_{i}", f"{row[other, other]} * {pull[i]}", [(across, pull[other])])
            lines.append(f"    const float {speed[i]} = ({scaled}) * over;")
    for i in reversed(range(eliminated)):
        alone = f"{pull[i]} * inverse_{i}"
        if assign(lines, speed[i], alone, [(factor[k, i], speed[k]) for k in range(i + 1, n)]) == alone:
            lines.append(f"    const float {speed[i]} = {alone};")
    return lines + [f"    {speeds}[{i}] = {speed[i]};" for i in range(n)]


def solve(n: int, matrix: dict[tuple[int, int], Term]) -> list[str]:
    factors = factorise(n, matrix)
    return [*factors.lines, *substitute(factors, "right", "velocity_radps")]


def wrapped(items: list[str], begin: str, indent: str, end: str) -> list[str]:
    """Arranges the items in lines of at most COLUMNS. The first line starts with `begin`, the others with `indent`."""
    lines = [begin]
    for i, item in enumerate(items):
        text = item + ("," if i < len(items) - 1 else end)
        if i > 0 and len(lines[-1]) + 1 + len(text) > COLUMNS:
            lines.append(indent + text)
        else:
            lines[-1] += text if i == 0 else f" {text}"
    return lines


def unknown(n: int, matrix: dict[tuple[int, int], Term]) -> list[str]:
    """Returns the variables of the normal equations: the entries of the matrix that are not 0 by construction, and the
    right-hand side."""
    return [*(term.variable for term in matrix.values() if term.variable), *(f"right_{i}" for i in range(n))]


def at_limit_functions(n: int, matrix: dict[tuple[int, int], Term]) -> list[str]:
    """Generates the struct that stores the equations, and the function that solves them with joints at their limits.
    The function is separate, so that the equations need not be stored in memory if no joint is at a limit."""
    names = unknown(n, matrix)
    lines = ["typedef struct {", *wrapped(names, "    float ", " " * 10, ";"), "} equations_t;", "",
             "static inline void solve(void *equations, float velocity_radps[]) {",
             "    const equations_t *const self = equations;",
             *wrapped([f"{name} = self->{name}" for name in names], "    const float ", " " * 16, ";"),
             *solve(n, matrix), "}", "",
             "static inline void lock(void *equations, uint8_t joints) {",
             "    equations_t *const self = equations;"]  # fmt: skip
    for joint in range(n):
        zeros = [term.variable for (i, j), term in matrix.items() if i != j and joint in (i, j) and term.variable]
        lines += [f"    if ((joints & {1 << joint}) != 0) {{",
                  f"        {' = '.join(f'self->{name}' for name in [*zeros, f'right_{joint}'])} = 0.0f;",
                  "    }"]  # fmt: skip
    head = "__attribute__((noinline)) static void solve_at_limit("
    lines += ["}", "", f"{head}joints_at_limit_t at_limit, float velocity_radps[],",
              *wrapped([f"float {name}" for name in names], " " * len(head), " " * len(head), ") {"),
              *wrapped(names, "    equations_t equations = {", " " * 29, "};"),
              f"    joints_at_limit_solve(at_limit, {n}, &equations, solve, lock, velocity_radps);", "}"]  # fmt: skip
    return lines


def sines_and_cosines(n: int) -> list[str]:
    """Generates sine_cosine_inline() of the half angles. Each step is done for all joints before the next step begins,
    so that each coefficient is loaded once. The results are bit-identical to those of sine_cosine_inline()."""
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
            steps.append(
                f"{name}_{{i}} = {name}_{{i}} + {other};"
                if last
                else f"{name}_{{i}} = ({name}_{{i}} + {other}) * z_{{i}};"
            )
    steps.append("sine_{i} = sine_{i} * (z_{i} * half_{i}) + half_{i};")
    steps.append("cosine_{i} = cosine_{i} * (z_{i} * z_{i}) + (1.0f - 0.5f * z_{i});")
    lines += [f"        {step.format(i=i)}" for step in steps for i in joints]
    lines.append("    } else {")
    for i in joints:
        lines.append(f"        const sine_cosine_t both_{i} = sine_cosine(half_{i});")
        lines += [f"        {part}_{i} = both_{i}.{part};" for part in ("sine", "cosine")]
    return [*lines, "    }"]


@dataclass
class Law:
    """The C code for an arm. body: body of its differential_ik_isotropic(). at_limit: definitions that the body needs
    for joints at their limits."""

    body: list[str]
    at_limit: list[str]


def law(arm: Arm, middle: int, right_first: bool) -> Law:
    n = len(arm.twist)
    lines = [
        "    const differential_ik_isotropic_t *const law = &config->isotropic;",
        "    const float *const position_rad = request->position_rad;",
        "    const pose_t *const target = request->target;",
    ]
    lines += sines_and_cosines(n)
    block = Block("m")
    joints = joints_of(block, arm, *([f"{part}_{i}" for i in range(n)] for part in ("sine", "cosine")))
    target = [Term(1.0, f"target->translation_m.{axis}") for axis in "xyz"]
    rotation = [Term(1.0, f"target->rotation.{axis}") for axis in "wxyz"]
    seen = see(block, arm, joints, target, rotation, middle, right_first)
    scale = abs(seen.turn[0].factor)  # factored out of all components of the rotation
    turn = [block.whole(Term(term.factor / scale, term.variable)) for term in seen.turn]
    equations, matrix = normal_equations(seen)
    difference = errors(arm, joints, middle, seen, equations)
    turned = [f"    const float turn_{axis} = {value(term)};" for axis, term in zip("wxyz", turn, strict=True)]
    named = set(re.findall(r"\bm\d+\b", "\n".join([*turned, *difference, *equations])))
    lines += [*block.text(Term(1.0, variable) for variable in named), *turned]
    lines.append("    /* target and -target are the same pose: choose the nearer one */")
    lines.append(f"    const float side = turn_w < 0.0f ? -{literal(scale)} : {literal(scale)};")
    lines.append("    const float pull_rotation = side * law->pull_rotation;")
    at_limit = ["    if (joints_at_limit_any(request->at_limit)) {",
                "        solve_at_limit(request->at_limit, velocity_radps,",
                *wrapped(unknown(n, matrix), " " * 23, " " * 23, ");"), "        return;", "    }"]  # fmt: skip
    body = [*lines, *difference, *equations, *at_limit, *solve(n, matrix)]
    return Law(body, at_limit_functions(n, matrix))


def fewest_operations(arm: Arm) -> Law:
    laws = [law(arm, middle, right_first) for middle in range(len(arm.twist)) for right_first in (False, True)]
    return min(laws, key=lambda law: operations(law.body))


# ---- forward kinematics


def forward_kinematics(arm: Arm) -> list[str]:
    """Generates equation (3) of the paper, evaluated from the end effector towards the torso."""
    n = len(arm.twist)
    lines = ["    (void)arm;"]
    lines += [f"    const sine_cosine_t half_{i} = sine_cosine(0.5f * position_rad[{i}]);" for i in range(n)]
    block = Block("m")
    joints = joints_of(block, arm, *([f"half_{i}.{part}" for i in range(n)] for part in ("sine", "cosine")))
    rotation, translation = constants(arm.effector.rotation), constants(arm.effector.translation_m)
    for joint, twist in zip(reversed(joints), reversed(arm.twist), strict=True):
        rotation = quaternion_product(
            block, constants(twist.rotation), quaternion_product(block, joint.quaternion, rotation)
        )
        translation = add(
            block, rotated(block, twist.matrix, joint.turned(block, translation)), constants(twist.translation_m)
        )
    lines += block.text([*rotation, *translation])
    members = [", ".join(value(x) for x in part) for part in (rotation, translation)]
    return [*lines, f"    return (pose_t){{{{{members[0]}}}, {{{members[1]}}}}};"]
