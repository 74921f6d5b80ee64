"""``make arms``: from each firmware/arms/NAME.toml its table in C, with kinematics and both laws written out for just this arm (differential_ik.py,
position_priority.py).

Run as ``python -m comanip_dev.arms.codegen [FILE...]``; NAME.c and NAME.h are written beside each file, and are committed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from comanip_dev import REPOSITORY
from comanip_dev.arms import position_priority
from comanip_dev.arms.description import Arm, ArmError, Pose, read
from comanip_dev.arms.differential_ik import fewest_operations, forward_kinematics
from comanip_dev.arms.straight_line import literal

ARMS = REPOSITORY / "firmware" / "arms"


def numbers(values: Sequence[float]) -> str:
    return ", ".join(literal(0.0 if abs(x) < 1e-12 else x) for x in values)


def pose(p: Pose) -> str:
    return f"{{{{{numbers(p.rotation)}}}, {{{numbers(p.translation_m)}}}}}"


def source(arm: Arm, origin: str) -> str:
    law = fewest_operations(arm)
    rows = [
        f"    {{{pose(fixed)}, {{0.0f, 0.0f, 1.0f}}, {numbers([*limits, arm.velocity_max_radps, jerk])}}},"
        for fixed, limits, jerk in zip(arm.fixed, arm.range_rad, arm.jerk_max_radps3, strict=True)
    ]
    return "\n".join([
        f"/* Made by `make arms` from {origin}: edit that. How: differential_ik.py, position_priority.py in host_tools/development/comanip_dev/arms. */",
        f'#include "{arm.name}.h"', "", '#include "../control/joint_ends.h"', '#include "../control/position_priority_terms.h"', '#include "../maths/trigonometry_inline.h"', '#include "../control/differential_ik.h"', "",
        f"static const arm_joint_t joints[{len(rows)}] = {{", *rows, "};", "",
        "/* arm_forward_kinematics() for this arm. */",
        "static pose_t forward_kinematics(const arm_t *arm, const float position_rad[]) {", *forward_kinematics(arm), "}", "",
        "/* joint_ends_solve() for this arm. */", *law.at_ends, "",
        "/* differential_ik_isotropic() for this arm. */",
        "static void isotropic(const arm_t *arm, const differential_ik_config_t *config, const differential_ik_request_t *request,",
        "                      float velocity_radps[]) {",
        *law.body, "}", "",
        "/* position_priority() for this arm. */",
        "static float written_out(const arm_t *arm, const position_priority_config_t *config, const position_priority_request_t *request,",
        "                         float feedback_radps[], float feedforward_radps[]) {",
        *position_priority.fewest_operations(arm), "}", "",
        f"const arm_t arm_{arm.name} = {{",
        f'    .name = "{arm.name}",', f"    .id = {arm.id},", f"    .joint_count = {len(rows)},", "    .joints = joints,",
        f"    .effector = {pose(arm.effector)},", "    .forward_kinematics = forward_kinematics,",
        "    .isotropic = isotropic,", "    .position_priority = written_out,", "};", "",
    ])  # fmt: skip


def header(arm: Arm, origin: str) -> str:
    guard = f"COMANIP_ARMS_{arm.name.upper()}_H"
    return "\n".join([
        f"/* {arm.title} */", f"/* Made by `make arms` from {origin}: edit that. */", f"#ifndef {guard}", f"#define {guard}", "",
        '#include "arm.h"', "", f"extern const arm_t arm_{arm.name};", "", "#endif", "",
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
