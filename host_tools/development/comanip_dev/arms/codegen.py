"""``make arms``: generates the C sources of each arm from its description, firmware/arms/NAME.toml.

firmware/arms/NAME.[ch] hold the arm's table and its forward kinematics, firmware/control/arms/NAME_ik.[ch] its inverse
kinematics, both as straight-line code for this arm. The generated files are committed.

Run as ``python -m comanip_dev.arms.codegen [ROOT/arms/NAME.toml...]``; the files go to ROOT/arms and ROOT/control/arms.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from comanip_dev import REPOSITORY
from comanip_dev.arms import differential_ik, position_priority
from comanip_dev.arms.description import Arm, ArmError, Pose, read
from comanip_dev.arms.straight_line import literal

ARMS = REPOSITORY / "firmware" / "arms"


def numbers(values: Sequence[float]) -> str:
    return ", ".join(literal(0.0 if abs(x) < 1e-12 else x) for x in values)


def pose(p: Pose) -> str:
    return f"{{{{{numbers(p.rotation)}}}, {{{numbers(p.translation_m)}}}}}"


def generated_from(arm: Arm) -> str:
    return f"/* Made by `make arms` from {arm.name}.toml: edit that. */"


def header(arm: Arm, name: str, room: str, include: str, declaration: str) -> str:
    guard = f"COMANIP_{room}_{name.upper()}_H"
    return "\n".join([
        f"/* {arm.title} */", generated_from(arm), f"#ifndef {guard}", f"#define {guard}", "",
        f'#include "{include}"', "", declaration, "", "#endif", "",
    ])  # fmt: skip


def table_header(arm: Arm) -> str:
    return header(arm, arm.name, "ARMS", "arm.h", f"extern const arm_t arm_{arm.name};")


def table_source(arm: Arm) -> str:
    rows = [
        f"    {{{pose(fixed)}, {{0.0f, 0.0f, 1.0f}}, {numbers([*limits, arm.velocity_max_radps, jerk])}}},"
        for fixed, limits, jerk in zip(arm.fixed, arm.range_rad, arm.jerk_max_radps3, strict=True)
    ]
    return "\n".join([
        generated_from(arm), "/* clang-format off */", f'#include "{arm.name}.h"', "",
        '#include "../maths/trigonometry.h"', "",
        f"static const arm_joint_t joints[{len(rows)}] = {{", *rows, "};", "",
        "/* arm_forward_kinematics() for this arm. */",
        "static pose_t forward_kinematics(const arm_t *arm, const float position_rad[]) {",
        *differential_ik.forward_kinematics(arm), "}", "",
        f"const arm_t arm_{arm.name} = {{",
        f'    .name = "{arm.name}",', f"    .id = {arm.id},", f"    .joint_count = {len(rows)},",
        "    .joints = joints,",
        f"    .effector = {pose(arm.effector)},", "    .forward_kinematics = forward_kinematics,", "};", "",
    ])  # fmt: skip


def ik_header(arm: Arm) -> str:
    return header(arm, f"{arm.name}_ik", "CONTROL_ARMS", "../arm_ik.h", f"extern const arm_ik_t arm_ik_{arm.name};")


def ik_source(arm: Arm) -> str:
    isotropic = differential_ik.fewest_operations(arm)
    return "\n".join([
        generated_from(arm), "/* clang-format off */", f'#include "{arm.name}_ik.h"', "",
        f'#include "../../arms/{arm.name}.h"', '#include "../../maths/trigonometry_inline.h"',
        '#include "../position_priority_terms.h"', "",
        "/* The isotropic equations, for joints_at_limit_solve(). */", *isotropic.at_limit, "",
        "/* differential_ik_isotropic() for this arm. */",
        "static void isotropic_ik(const arm_t *arm, const differential_ik_config_t *config,",
        "                         const differential_ik_request_t *request, float velocity_radps[]) {",
        *isotropic.body, "}", "",
        "/* position_priority() for this arm. */",
        "static float position_priority_ik(const arm_t *arm, const position_priority_config_t *config,",
        "                                  const position_priority_request_t *request, float feedback_radps[],",
        "                                  float feedforward_radps[]) {",
        *position_priority.fewest_operations(arm), "}", "",
        f"const arm_ik_t arm_ik_{arm.name} = {{&arm_{arm.name}, isotropic_ik, position_priority_ik}};", "",
    ])  # fmt: skip


def files(path: Path) -> dict[Path, str]:
    """The text of each generated file for ROOT/arms/NAME.toml. ArmError or OSError if the description cannot be
    read."""
    arm = read(path)
    ik = path.parent.parent / "control" / "arms" / f"{path.stem}_ik"
    return {
        path.with_suffix(".c"): table_source(arm), path.with_suffix(".h"): table_header(arm),
        ik.with_suffix(".c"): ik_source(arm), ik.with_suffix(".h"): ik_header(arm),
    }  # fmt: skip


def main(argv: Sequence[str]) -> int:
    for path in [Path(argument) for argument in argv] or sorted(ARMS.glob("*.toml")):
        try:
            written = files(path)
        except (ArmError, OSError) as error:
            print(f"make arms: {error}", file=sys.stderr)
            return 2
        for file, text in written.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        print(f"comanip: {', '.join(map(str, written))}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
