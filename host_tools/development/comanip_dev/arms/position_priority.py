"""Generates the equations of firmware/control/position_priority.c for one arm, as lines of a C function.

As in differential_ik.py, errors, motion and axes are expressed in the frame of one joint, chosen so that the code
needs the fewest operations. If joints are at their limits, the general position_priority_solve() solves the equations.
"""

from __future__ import annotations

from comanip_dev.arms.description import Arm
from comanip_dev.arms.differential_ik import cross, factorise, joints_of, see, sines_and_cosines, substitute, to_middle
from comanip_dev.arms.straight_line import ONE, ZERO, Block, Term, Vector, literal, operations, value

CURVATURE = "POSITION_PRIORITY_CURVATURE_SHARE * __builtin_fabsf({})"


UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def named(member: str, axes: str = "xyz") -> Vector:
    return [Term(1.0, f"{member}.{axis}") for axis in axes]


def scaled(block: Block, factor: Term, v: Vector) -> Vector:
    return [block.multiply(factor, x) for x in v]


def task_damping(block: Block, moments: list[Vector]) -> list[Vector]:
    """Returns a = I + damping (J_p J_p^T + floor I)^-1, 3 x 3, computed by cofactors."""
    floor = Term(1.0, "POSITION_PRIORITY_TASK_FLOOR_M2")
    m = [[ZERO] * 3 for _ in range(3)]
    cofactor = [[ZERO] * 3 for _ in range(3)]
    for i, j in UPPER:
        total = block.sum(block.multiply(moment[i], moment[j]) for moment in moments)
        m[i][j] = m[j][i] = block.add(total, floor) if i == j else total
    for i, j in UPPER:
        (a, b), (c, d) = ([(k + 1) % 3, (k + 2) % 3] for k in (i, j))
        cofactor[i][j] = cofactor[j][i] = block.add(block.multiply(m[a][c], m[b][d]), -block.multiply(m[a][d], m[b][c]))
    determinant, trace = block.dot(m[0], cofactor[0]), block.sum(m[i][i] for i in range(3))
    scale = block.apply("position_priority_task_scale({}, {})", determinant, trace)
    return [
        [block.add(block.multiply(scale, cofactor[i][j]), ONE if i == j else ZERO) for j in range(3)] for i in range(3)
    ]


def law(arm: Arm, middle: int, right_first: bool) -> list[str]:
    n = len(arm.twist)
    block = Block("m")
    joints = joints_of(block, arm, *([f"{part}_{i}" for i in range(n)] for part in ("sine", "cosine")))
    seen = see(
        block, arm, joints, named("target->translation_m"), named("target->rotation", "wxyz"), middle, right_first
    )
    velocity, angular_velocity = (
        to_middle(block, arm, joints, middle, named(f"request->motion->{part}"), 0, is_point=False)
        for part in ("velocity_mps", "angular_velocity_radps")
    )
    gain, weight = (Term(1.0, f"config->{name}") for name in ("gain_per_s", "orientation_weight_m2"))

    whole_way = [block.add(t, -h) for t, h in zip(seen.target, seen.hand, strict=True)]
    distance = block.apply("__builtin_sqrtf({})", block.dot(whole_way, whole_way))
    way = scaled(block, block.apply("position_priority_share({})", distance), whole_way)
    scale = abs(seen.turn[0].factor)  # factored out of all components of the rotation
    w, *vector = (Term(term.factor / scale, term.variable) for term in seen.turn)
    twice = literal(2.0 * scale)
    # target and -target are the same pose: choose the nearer one
    side = block.apply(f"{{}} < 0.0f ? -{twice} : {twice}", w)
    turn = scaled(block, side, vector)
    stiffness = block.apply("position_priority_stiffness({})", block.dot(turn, turn))
    weighted_stiffness = block.multiply(weight, stiffness)

    moments = [cross(block, axis, lever) for axis, lever in zip(seen.axes, seen.levers, strict=True)]
    task = task_damping(block, moments)
    results: dict[str, Term] = {}
    entries: dict[tuple[int, int], Term] = {}
    damping: list[Term] = []
    curvatures = [ZERO] * n
    for i, (axis, moment) in enumerate(zip(seen.axes, moments, strict=True)):
        limits = ", ".join(literal(limit) for limit in arm.range_rad[i])
        margin = block.apply(f"position_priority_margin({limits}, position_rad[{i}])")
        pull = block.add(block.multiply(weight, block.dot(axis, turn)), block.multiply(weighted_stiffness, margin))
        results[f"feedback_{i}"] = block.multiply(gain, block.add(block.dot(moment, way), pull))
        results[f"feedforward_{i}"] = block.add(
            block.dot(moment, velocity), block.multiply(weight, block.dot(axis, angular_velocity))
        )
        damping.append(block.apply("position_priority_damping({}, {})", weighted_stiffness, margin))
        damped = [block.dot(row, moment) for row in task]
        for j in range(i + 1):
            turned = block.multiply(weight, block.dot(axis, seen.axes[j]) if j < i else ONE)
            entries[i, j] = block.add(block.dot(damped, moments[j]), turned)
            curvature = block.dot(cross(block, seen.axes[j], way), moment)
            if not curvature.is_zero:
                size = block.apply("__builtin_fabsf({})", Term(abs(curvature.factor), curvature.variable))
                for joint in {i, j}:
                    curvatures[joint] = block.add(curvatures[joint], size)
    for i in range(n):
        share = block.multiply(Term(1.0, "POSITION_PRIORITY_CURVATURE_SHARE"), curvatures[i])
        entries[i, i] = block.add(entries[i, i], block.add(damping[i], share))
    results |= {f"matrix_{i}{j}": term for (i, j), term in entries.items() if not term.is_zero}
    matrix = {(i, j): ZERO if term.is_zero else Term(1.0, f"matrix_{i}{j}") for (i, j), term in entries.items()}
    factors = factorise(n, matrix, inverse="ldlt_inverse({})")
    return [
        "    (void)arm;",
        "    const float *const position_rad = request->position_rad;",
        "    const pose_t *const target = request->target;",
        *sines_and_cosines(n),
        *block.text([*results.values(), distance]),
        *(f"    const float {name} = {value(term)};" for name, term in results.items()),
        "    if (joints_at_limit_any(request->at_limit)) {",
        "        position_priority_equations_t equations;",
        *(f"        equations.normal.matrix[{j}][{i}] = {value(term)};" for (i, j), term in matrix.items()),
        *(f"        equations.{side}[{i}] = {side}_{i};" for side in ("feedback", "feedforward") for i in range(n)),
        f"        position_priority_solve(&equations, {n}, request->at_limit, feedback_radps, feedforward_radps);",
        f"        return {value(distance)};",
        "    }",
        *factors.lines,
        *substitute(factors, "feedback", "feedback_radps"),
        *substitute(factors, "feedforward", "feedforward_radps"),
        f"    return {value(distance)};",
    ]


def fewest_operations(arm: Arm) -> list[str]:
    laws = [law(arm, middle, right_first) for middle in range(len(arm.twist)) for right_first in (False, True)]
    return min(laws, key=operations)
