"""What `make arms` writes: law (4) for one arm alone, against numpy in double precision and against the law for any arm."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip import arm_codegen, core
from comanip._core import ffi, lib

HOAP3 = "hoap3_right"


def config(gain=35.0, weight=(0.01, 100.0), damping=0.01, frame=lib.ERROR_FRAME_TARGET):
    result = ffi.new("velocity_control_config_t *")
    result.gain_per_s = [gain] * 8
    result.weight = [weight[0]] * 4 + [weight[1]] * 4
    result.damping, result.error_frame = damping, frame
    lib.velocity_control_prepare(result)
    return result


def solve(law, arm, configuration, q, target, blocked=0) -> np.ndarray:
    position, velocity = ffi.new("float[8]", q.tolist()), ffi.new("float[8]")
    pose = ffi.new("pose_t *", (target[:4].tolist(), oracle.translation(target).tolist()))
    request = ffi.new("velocity_request_t *", {"position_rad": position, "target": pose, "blocked": blocked})
    law(arm.table, configuration, request, velocity)
    return np.array(list(velocity)[: arm.joint_count])


@pytest.fixture
def arm():
    return core.Arm.named(HOAP3)


@pytest.fixture
def inputs(rng, arm):
    q = rng.uniform(arm.position_min_rad, arm.position_max_rad, (300, 4)).astype(np.float32)
    return list(zip(q, oracle.random_poses(rng, 300, 0.3), strict=True))


def test_the_committed_files_are_what_the_description_gives():
    for path in sorted(arm_codegen.ARMS.glob("*.toml")):
        arm = arm_codegen.read(path)
        assert path.with_suffix(".c").read_text() == arm_codegen.source(arm, path.name)
        assert path.with_suffix(".h").read_text() == arm_codegen.header(arm, path.name)


@pytest.mark.parametrize("frame", [lib.ERROR_FRAME_TORSO, lib.ERROR_FRAME_TARGET])
@pytest.mark.parametrize("weight", [(1.0, 1.0), (0.01, 100.0)])
def test_one_joint_or_more_blocked_is_the_arm_without_them(arm, inputs, frame, weight):
    """In double precision: the Jacobian without the columns. The fast law, the one for any arm and the general one alike."""
    configuration = config(weight=weight, frame=frame)
    laws = (lib.velocity_control, lib.velocity_control_isotropic, lib.velocity_control_general)
    w = np.repeat(weight, 4)
    for number, (q, target) in enumerate(inputs):
        blocked = number % 15
        hand, jacobian = (x[0] for x in oracle.evaluate(oracle.hoap3(), q[None]))
        goal = target.astype(float) * (1 if hand[:4] @ target[:4] >= 0 else -1)
        error = goal - hand
        if frame == lib.ERROR_FRAME_TARGET:
            jacobian = np.stack([oracle.multiply(oracle.conjugate(goal), column) for column in jacobian.T], axis=1)
            error = oracle.multiply(oracle.conjugate(goal), error)
        jacobian = jacobian * [0 if blocked >> i & 1 else 1 for i in range(4)]
        normal = jacobian.T @ (w[:, None] * jacobian) + 0.01 * np.eye(4)
        expected = np.linalg.solve(normal, jacobian.T @ (w * 35 * error))
        for law in laws:
            found = solve(law, arm, configuration, q, target, blocked)
            scale = max(3.5, np.linalg.norm(expected))
            assert np.abs(found - expected).max() / scale < max(5e-5, 5e-8 * max(4, weight[1]) / 0.01)
            assert all(found[i] == 0 for i in range(4) if blocked >> i & 1)


def test_a_target_out_of_all_reach_is_left_to_the_general_law(arm, inputs):
    """Where the damping is too little beside J^T W J: the very same bits."""
    configuration = config(weight=(0.01, 100.0), damping=1e-3)
    assert configuration.isotropic.applies
    for q, target in inputs[:50]:
        far = oracle.pose(target[:4], [300.0, -200.0, 100.0])
        general = solve(lib.velocity_control_general, arm, configuration, q, far)
        assert np.array_equal(solve(lib.velocity_control, arm, configuration, q, far), general)
        assert np.isfinite(general).all()


@pytest.mark.parametrize(
    ("change", "applies"),
    [({}, True), ({"weight": (1.0, 1.0)}, True), ({"weight": (10.0, 10.0)}, False), ({"damping": 0.0}, False), ({"weight": (0.0, 0.0)}, False),
     ({"weight": (1.0, 0.0)}, False)],
)  # fmt: skip
def test_where_the_fast_law_applies(change, applies):
    assert config(**change).isotropic.applies == applies


@pytest.mark.parametrize("part", ["gain_per_s", "weight"])
@pytest.mark.parametrize("component", range(8))
def test_any_other_diagonal_is_general(part, component):
    configuration = config(weight=(1.0, 1.0))
    getattr(configuration, part)[component] *= 1.5
    lib.velocity_control_prepare(configuration)
    assert not configuration.isotropic.applies


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["q", "target"])
def test_what_is_not_finite_comes_out_as_not_finite(arm, inputs, value, where):
    """So that the joint limits see it: it never passes for a velocity."""
    q, target = (x.copy() for x in inputs[0])
    (q if where == "q" else target)[1] = value
    assert not np.isfinite(solve(lib.velocity_control, arm, config(), q, target)).all()


# ---- descriptions


def described(tmp_path, text: str):
    path = tmp_path / "arm.toml"
    path.write_text(text)
    return arm_codegen.read(path)


GOOD = 'name = "a"\nid = 1\nvelocity_max_radps = 2.0\n[[frame]]\nalpha_deg = 90.0\nrange_deg = [-90.0, 90.0]\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GOOD.replace("alpha_deg", "alpha"), "frame: alpha: unknown, expected a_m, alpha_deg"),
        (GOOD.replace("id = 1\n", ""), "id is missing"),
        (GOOD.replace("range_deg = [-90.0, 90.0]\n", ""), "0 joints"),
        (GOOD.replace('"a"', "a"), "Invalid"),
    ],
)
def test_a_bad_description_is_named(tmp_path, text, message):
    with pytest.raises(arm_codegen.ArmError, match=message) as raised:
        described(tmp_path, text)
    assert "arm.toml" in str(raised.value)


def test_a_description_is_modified_dh(tmp_path):
    """The torso-to-joint transform of one row, Rot_x(alpha) Trans(a, 0, d) Rot_z(theta), by numpy."""
    arm = described(tmp_path, GOOD.replace("alpha_deg = 90.0", "alpha_deg = 30.0\na_m = 0.2\nd_m = 0.3\ntheta_deg = 40.0"))
    x, z = oracle.rotation([1, 0, 0], np.radians(30)), oracle.rotation([0, 0, 1], np.radians(40))
    expected = oracle.multiply(oracle.pose(x, [0, 0, 0]), oracle.multiply(oracle.pose([1, 0, 0, 0], [0.2, 0, 0.3]), oracle.pose(z, [0, 0, 0])))
    (fixed,) = arm.fixed
    assert oracle.pose_distance(oracle.pose(fixed.rotation, fixed.translation_m), expected) < 1e-12
