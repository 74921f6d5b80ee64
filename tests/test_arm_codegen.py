"""Checks the C code that `make arms` generates for a particular arm, i.e. the arm's kinematics and control law (4),
against numpy in double precision and against the C functions that solve the control law for any arm."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess

import c_library
import cantools
import numpy as np
import oracle
import pytest
from comanip import core
from comanip._core import ffi, lib
from comanip_dev.arms import codegen as arm_codegen
from comanip_dev.arms import description as arm_description
from comanip_dev.arms.description import ArmError
from simulation import REPOSITORY

HOAP3 = "hoap3_right"
FIRMWARE = REPOSITORY / "firmware"


def config(gain=35.0, weight=(0.01, 100.0), damping=0.01, frame=lib.ERROR_FRAME_TARGET):
    result = ffi.new("differential_ik_config_t *")
    result.gain_per_s = [gain] * 8
    result.weight = [weight[0]] * 4 + [weight[1]] * 4
    result.damping, result.error_frame = damping, frame
    lib.differential_ik_prepare(result)
    return result


def for_this_arm(arm, *arguments) -> None:
    lib.arm_ik_differential(arm.ik, *arguments)


def for_any_arm(arm, *arguments) -> None:
    lib.differential_ik_isotropic(arm.table, *arguments)


def general_form(arm, *arguments) -> None:
    lib.differential_ik_general(arm.table, *arguments)


def solve(law, arm, configuration, q, target, lower=0, upper=0) -> np.ndarray:
    position, velocity = ffi.new("float[8]", q.tolist()), ffi.new("float[8]")
    pose = ffi.new("pose_t *", (target[:4].tolist(), oracle.translation(target).tolist()))
    request = ffi.new(
        "differential_ik_request_t *", {"position_rad": position, "target": pose, "at_limit": (lower, upper)}
    )
    law(arm, configuration, request, velocity)
    return np.array(list(velocity)[: arm.joint_count])


def hand_pose(arm, q) -> tuple[np.ndarray, np.ndarray]:
    pose = arm.table.forward_kinematics(arm.table, ffi.new("float[8]", q.tolist()))
    rotation, translation = pose.rotation, pose.translation_m
    return np.array([rotation.w, rotation.x, rotation.y, rotation.z]), np.array(
        [translation.x, translation.y, translation.z]
    )


@pytest.fixture
def arm():
    return core.Arm.named(HOAP3)


@pytest.fixture
def inputs(rng, arm):
    q = rng.uniform(arm.position_min_rad, arm.position_max_rad, (300, 4)).astype(np.float32)
    return list(zip(q, oracle.random_poses(rng, 300, 0.3), strict=True))


def test_the_dbc_names_all_arms(tmp_path):
    for folder in ("arms", "schema"):
        shutil.copytree(FIRMWARE / folder, tmp_path / folder)
    dbc = tmp_path / "schema" / "comanip.dbc"
    assert arm_codegen.dbc_with_arms(tmp_path) == {dbc: dbc.read_text()}, "run `make arms`"
    names = cantools.database.load_file(dbc).get_message_by_name("FirmwareIdentity").get_signal_by_name("arm").choices
    number = max(names) + 1
    text = (tmp_path / "arms" / f"{HOAP3}.toml").read_text().replace(f'name = "{HOAP3}"', 'name = "other"')
    other = tmp_path / "arms" / "other.toml"
    other.write_text(text)
    with pytest.raises(ArmError, match=r"other\.toml: id: 0 is already used by hoap3_right"):
        arm_codegen.dbc_with_arms(tmp_path)
    other.write_text(text.replace("id = 0", f"id = {number}"))
    changed = cantools.database.load_string(arm_codegen.dbc_with_arms(tmp_path)[dbc], "dbc")
    for message in ("FirmwareIdentity", "ClassicFirmwareIdentity"):
        signal = changed.get_message_by_name(message).get_signal_by_name("arm")
        assert signal.choices == names | {number: "other"}


def test_the_committed_files_match_the_description():
    for path in sorted(arm_codegen.ARMS.glob("*.toml")):
        for file, text in arm_codegen.files(path).items():
            assert file.read_text() == text, file


@pytest.mark.parametrize("frame", [lib.ERROR_FRAME_TORSO, lib.ERROR_FRAME_TARGET])
@pytest.mark.parametrize("weight", [(1.0, 1.0), (0.01, 100.0)])
def test_joints_at_a_limit_stay_there_and_the_others_follow(arm, inputs, frame, weight):
    """The generated law, the isotropic law for any arm and the general law agree with a reference in double precision.
    The reference repeatedly drops the Jacobian columns of the joints that would move past their limit, until no joint
    would."""
    configuration = config(weight=weight, frame=frame)
    laws = (for_this_arm, for_any_arm, general_form)
    w = np.repeat(weight, 4)
    blocked_counts = np.zeros(5, int)
    for number, (q, target) in enumerate(inputs):
        upper = number // 16 % 16 & number % 16
        lower = number % 16 & ~upper
        beyond = np.array([(upper >> i & 1) - (lower >> i & 1) for i in range(4)])
        hand, jacobian = (x[0] for x in oracle.evaluate(oracle.hoap3(), q[None]))
        goal = target.astype(float) * (1 if hand[:4] @ target[:4] >= 0 else -1)
        error = goal - hand
        if frame == lib.ERROR_FRAME_TARGET:
            jacobian = np.stack([oracle.multiply(oracle.conjugate(goal), column) for column in jacobian.T], axis=1)
            error = oracle.multiply(oracle.conjugate(goal), error)
        free, clear = np.ones(4, bool), np.inf
        while True:
            free_jacobian = jacobian * free
            normal = free_jacobian.T @ (w[:, None] * free_jacobian) + 0.01 * np.eye(4)
            expected = np.linalg.solve(normal, free_jacobian.T @ (w * 35 * error))
            judged = (beyond != 0) & free
            clear = min(clear, *np.abs(expected[judged]), np.inf)
            if not (judged & (expected * beyond > 0)).any():
                break
            free &= expected * beyond <= 0
        if clear < 1e-2:
            continue  # near zero velocity, rounding decides whether a joint is blocked
        blocked_counts[4 - free.sum()] += 1
        for law in laws:
            found = solve(law, arm, configuration, q, target, lower, upper)
            scale = max(3.5, np.linalg.norm(expected))
            assert np.abs(found - expected).max() / scale < max(5e-5, 5e-8 * max(4, weight[1]) / 0.01)
            assert (found[~free] == 0).all()
            assert (found * beyond <= 0).all()
    assert (blocked_counts > 0).all()  # every number of blocked joints occurs, from none to all


def test_a_target_far_out_of_reach_uses_the_general_law(arm, inputs):
    """The generated law calls the general law if the damping is too small relative to J^T W J, as it is for a distant
    target. The result is then that of the general law, bit for bit."""
    configuration = config(weight=(0.01, 100.0), damping=1e-3)
    assert configuration.isotropic.applies
    for q, target in inputs[:50]:
        far = oracle.pose(target[:4], [300.0, -200.0, 100.0])
        general = solve(general_form, arm, configuration, q, far)
        assert np.array_equal(solve(for_this_arm, arm, configuration, q, far), general)
        assert np.isfinite(general).all()


@pytest.mark.parametrize(
    ("change", "applies"),
    [({}, True), ({"weight": (1.0, 1.0)}, True), ({"weight": (10.0, 10.0)}, False), ({"damping": 0.0}, False),
     ({"damping": 1.01e-3}, True), ({"damping": 0.99e-3}, False), ({"weight": (0.0, 0.0)}, False),
     ({"weight": (1.0, 0.0)}, False)],
)  # fmt: skip
def test_where_the_fast_law_applies(change, applies):
    assert config(**change).isotropic.applies == applies


@pytest.mark.parametrize("part", ["gain_per_s", "weight"])
@pytest.mark.parametrize("component", range(8))
def test_any_other_diagonal_is_general(part, component):
    configuration = config(weight=(1.0, 1.0))
    getattr(configuration, part)[component] *= 1.5
    lib.differential_ik_prepare(configuration)
    assert not configuration.isotropic.applies


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["q", "target"])
def test_non_finite_input_gives_non_finite_output(arm, inputs, value, where):
    """Non-finite input always produces a non-finite velocity, which the joint limits detect."""
    q, target = (x.copy() for x in inputs[0])
    (q if where == "q" else target)[1] = value
    assert not np.isfinite(solve(for_this_arm, arm, config(), q, target)).all()


# ---- generated arms

INCLUDES = [f"-I{FIRMWARE / 'arms'}", f"-I{FIRMWARE / 'control' / 'arms'}"]
LAW_SOURCES = (
    "arm",
    "dual_quaternion",
    "joints_at_limit",
    "ldlt",
    "pose",
    "position_priority",
    "trigonometry",
    "differential_ik",
    "differential_ik_general",
)


def position_priority(law, arm, q, target, motion, lower=0, upper=0) -> np.ndarray:
    """Returns one array: the joint velocities that correct the error, the joint velocities that follow the target's
    motion, and the position error."""
    position = ffi.new("float[8]", q.tolist())
    config = ffi.new("position_priority_config_t *", {"gain_per_s": 35.0, "orientation_weight_m2": 1e-5})
    pose = ffi.new("pose_t *", (target[:4].tolist(), oracle.translation(target).tolist()))
    twist = ffi.new("twist_t *", (motion[:3].tolist(), motion[3:].tolist()))
    request = ffi.new(
        "position_priority_request_t *",
        {"position_rad": position, "target": pose, "motion": twist, "at_limit": (lower, upper)},
    )
    for_error, for_motion = ffi.new("float[8]"), ffi.new("float[8]")
    distance = law(arm.table, config, request, for_error, for_motion)
    return np.array([*list(for_error)[: arm.joint_count], *list(for_motion)[: arm.joint_count], distance])


def write_description(path, rows, effector) -> None:
    """Writes an arm description. Each row describes a joint by (alpha_deg, a_m, d_m, theta_deg)."""
    frames = [(*row, True) for row in rows] + [(*effector, False)]
    lines = [f'name = "{path.stem}"', "id = 1", "velocity_max_radps = 3.0"]
    for alpha, a, d, theta, is_joint in frames:
        lines += ["[[frame]]", f"alpha_deg = {alpha}", f"a_m = {a}", f"d_m = {d}", f"theta_deg = {theta}"]
        lines += ["range_deg = [-170.0, 170.0]"] if is_joint else []
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines))


def compiled(folder, name: str):
    """Compiles the arm with its inverse kinematics into a separate library and loads it."""
    command = ["gcc", "-std=c11", "-O2", "-ffp-contract=off", "-fno-math-errno", "-Wall", "-Wextra", "-Wpedantic",
               "-Wconversion",
               "-Wdouble-promotion", "-Wshadow", "-Werror", "-fPIC", *INCLUDES]  # fmt: skip
    sources = [file for file in sorted(FIRMWARE.rglob("*.c")) if file.stem in LAW_SOURCES]
    parts = [str(target) for target, _ in c_library.objects(sources, command)]
    parts += [str(folder / "arms" / f"{name}.c"), str(folder / "control" / "arms" / f"{name}_ik.c")]
    library = folder / f"{name}.so"
    subprocess.run([*command, "-shared", *parts, "-o", str(library)], check=True)
    loaded = ctypes.CDLL(str(library))
    return loaded, ffi.cast("arm_ik_t *", ctypes.addressof(ctypes.c_char.in_dll(loaded, f"arm_ik_{name}")))


class Loaded:
    """The attributes of an arm that solve() needs."""

    def __init__(self, library, ik):
        self.library, self.ik, self.table, self.joint_count = library, ik, ik.arm, ik.arm.joint_count


RIGHT_ANGLES = (-90.0, 0.0, 90.0)


@pytest.mark.parametrize("angles", ["right", "any"])
@pytest.mark.parametrize("n", range(1, 9))
def test_kinematics_and_law_for_arms_of_any_number_of_joints(rng, tmp_path, n, angles):
    """The arms with right angles also have some zero offsets and lengths, as real arms do, so that the generator
    eliminates most terms."""
    right = angles == "right"
    rows = []
    for _ in range(n + 1):
        alpha, theta = rng.choice(RIGHT_ANGLES, 2) if right else rng.uniform(-180, 180, 2)
        a, d = rng.choice([0.0, 0.1, 0.25], 2) if right else rng.uniform(-0.2, 0.2, 2)
        rows.append((float(alpha), float(a), float(d), float(theta)))
    name = f"arm_of_{n}"
    path = tmp_path / "arms" / f"{name}.toml"
    write_description(path, rows[:-1], rows[-1])
    assert arm_codegen.main([str(path)]) == 0
    arm = Loaded(*compiled(tmp_path, name))

    def row_pose(row):
        x, z = (oracle.rotation(axis, np.radians(angle)) for axis, angle in (([1, 0, 0], row[0]), ([0, 0, 1], row[3])))
        return oracle.multiply(
            oracle.pose(x, [0, 0, 0]),
            oracle.multiply(oracle.pose([1, 0, 0, 0], [row[1], 0, row[2]]), oracle.pose(z, [0, 0, 0])),
        )

    fixed, effector = np.array([row_pose(row) for row in rows[:-1]]), row_pose(rows[-1])
    q = rng.uniform(-2.9, 2.9, (200, n)).astype(np.float32)
    targets = oracle.random_poses(rng, 200, 0.5)
    hand, jacobian = oracle.chain_kinematics(fixed, np.tile([0.0, 0, 1], (n, 1)), effector, q)
    for row, expected in zip(q, hand, strict=True):
        found = hand_pose(arm, row)
        assert np.abs(found[0] - expected[:4] * np.sign(found[0] @ expected[:4])).max() < 2e-6
        assert np.abs(found[1] - oracle.translation(expected)).max() < 2e-6
    for frame, frame_name in ((lib.ERROR_FRAME_TORSO, "torso"), (lib.ERROR_FRAME_TARGET, "target")):
        otherwise = 0
        for weight in ((1.0, 1.0), (0.01, 100.0)):
            configuration = config(weight=weight, frame=frame)
            assert configuration.isotropic.applies
            expected = oracle.law(
                jacobian, hand, targets.astype(float), 35.0, np.repeat(weight, 4), np.float32(0.01), frame_name
            )
            found = np.array([solve(for_this_arm, arm, configuration, *pair) for pair in zip(q, targets, strict=True)])
            scale = np.maximum(3.5, np.linalg.norm(expected, axis=1))
            # the bound is wider than for HOAP-3, because the rounding error of J^T W J grows with the square of the
            # reach, which is 2 m here and 0.3 m for HOAP-3
            bound = 4 * max(5e-5, 5e-8 * max(4, weight[1]) / 0.01)
            assert (np.abs(found - expected).max(axis=1) / scale).max() < bound
            # for joints at their limits, compare with the general law, which is tested against double precision above
            for pair in zip(q, targets, strict=True):
                lower, upper = (int(x) for x in rng.integers(0, 2**n, 2))
                written, general = (
                    solve(law, arm, configuration, *pair, lower, upper) for law in (for_this_arm, general_form)
                )
                sent = [(1 << i) * (written[i] > 0) for i in range(n)], [(1 << i) * (written[i] < 0) for i in range(n)]
                assert sum(sent[0]) & upper == 0 and sum(sent[1]) & lower == 0
                if np.array_equal(written == 0, general == 0):  # otherwise the two laws blocked different joints
                    assert np.abs(written - general).max() / max(3.5, np.abs(general).max()) < 2 * bound
                else:
                    otherwise += 1
        assert otherwise <= 2
    # the result matches the law for any arm, which test_position_priority.py tests against double precision
    otherwise = 0
    for row, target in zip(q, targets, strict=True):
        motion = rng.normal(size=6)
        for lower, upper in ((0, 0), rng.integers(0, 2**n, 2)):
            written, general = (position_priority(law, arm, row, target, motion, int(lower), int(upper))
                                for law in (arm.ik.position_priority, lib.position_priority))  # fmt: skip
            if np.array_equal(written == 0, general == 0):
                assert np.abs(written - general).max() < 1e-2 * max(1.0, np.abs(general).max())
            else:
                otherwise += 1
    assert otherwise <= 4


def test_generated_code_compiles_for_any_arm(rng, tmp_path):
    """The generated code compiles without warnings such as unused variables, even if right angles and zero lengths
    eliminate many terms."""
    flags = [
        "-std=c11",
        *INCLUDES,
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Wdouble-promotion",
        "-Wshadow",
        "-Werror",
        "-fsyntax-only",
    ]
    written = []
    rows_of = [
        [(-90.0, 0.1, 0.1, 90.0), (0.0, 0.1, 0.1, 0.0), (-90.0, 0.0, 0.0, -90.0), (-90.0, 0.1, 0.0, 90.0)]
    ]  # the generated code for this arm once had unused variables
    for n in [1, 2, 3, 3, 3, 4, 4, 4, 5, 6, 7, 8] * 2:
        rows_of.append(
            [
                tuple(
                    float(x)
                    for x in (*rng.choice(RIGHT_ANGLES, 1), *rng.choice([0.0, 0.1], 2), *rng.choice(RIGHT_ANGLES, 1))
                )
                for _ in range(n + 1)
            ]
        )
    for number, rows in enumerate(rows_of):
        path = tmp_path / "arms" / f"arm_{number}.toml"
        write_description(path, rows[:-1], rows[-1])
        assert arm_codegen.main([str(path)]) == 0
        written += [str(path.with_suffix(".c")), str(tmp_path / "control" / "arms" / f"arm_{number}_ik.c")]
    assert subprocess.run(["gcc", *flags, *written], capture_output=True, text=True, check=True).stderr == ""


# ---- descriptions


def described(tmp_path, text: str):
    path = tmp_path / "arm.toml"
    path.write_text(text)
    return arm_description.read(path)


GOOD = 'name = "arm"\nid = 1\nvelocity_max_radps = 2.0\n[[frame]]\nalpha_deg = 90.0\nrange_deg = [-90.0, 90.0]\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GOOD.replace("alpha_deg", "alpha"), "frame 1: alpha: unknown, expected a_m, alpha_deg"),
        (GOOD.replace("id = 1\n", ""), "id is missing"),
        ("", "frame is missing"),
        (GOOD.replace("range_deg = [-90.0, 90.0]\n", ""), "0 joints"),
        (GOOD + 8 * "[[frame]]\nrange_deg = [-90, 90]\n", "9 joints .*, expected 1 to 8"),
        (GOOD.replace('"arm"', "arm"), "Invalid"),
        (GOOD.replace('"arm"', '"other"'), "name: 'other': expected the file's name"),
        (GOOD.replace("[-90.0, 90.0]", "5"), "range_deg: 5: expected two numbers"),
        (GOOD.replace("[-90.0, 90.0]", "[90, -90]"), "expected the lower limit first"),
        (GOOD.replace("[-90.0, 90.0]", "[-1000, 90]"), "range_deg: -1000: expected a number from -458"),
        (GOOD.replace("alpha_deg = 90.0", "alpha_deg = nan"), "alpha_deg: nan: expected a number"),
        (GOOD.replace("alpha_deg = 90.0", 'a_m = "long"'), "a_m: 'long': expected a number"),
        (GOOD.replace("2.0", "33.0"), "velocity_max_radps: 33.0: expected a number from 0.001 to 32"),
        (GOOD.replace("[[frame]]", "[frame]"), "frame: .*: expected a list of tables"),
        ("jerk_max_radps3 = 999\n" + GOOD, "arm.toml: jerk_max_radps3: 999: expected a number from 1000 to 1e.06"),
        (GOOD + "jerk_max_radps3 = 2e6\n", "frame 1: jerk_max_radps3: 2000000.0: expected a number from 1000 to 1e.06"),
        ("drive_lag_max_s = 0\n" + GOOD, "arm.toml: drive_lag_max_s: 0: expected a number from 0.001 to 0.1"),
        ('drive_lag_max_s = "x"\n' + GOOD, "arm.toml: drive_lag_max_s: 'x': expected a number from 0.001 to 0.1"),
        (GOOD + "drive_lag_max_s = 0.01\n", "frame 1: drive_lag_max_s: unknown"),
        (GOOD + "[[frame]]\njerk_max_radps3 = 2e4\n", "frame 2: jerk_max_radps3: expected in joints only"),
    ],
)
def test_a_bad_description_is_named(tmp_path, text, message):
    with pytest.raises(ArmError, match=message) as raised:
        described(tmp_path, text)
    assert "arm.toml" in str(raised.value)


def test_an_invalid_description_writes_nothing(tmp_path, capsys):
    path = tmp_path / "arm.toml"
    path.write_bytes(b"\xff\xfe")
    for argument in (path, tmp_path / "nothing.toml", tmp_path):
        assert arm_codegen.main([str(argument)]) == 2
        assert str(argument) in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == [path]


def test_the_lag_of_the_drives_is_the_arms(tmp_path):
    assert described(tmp_path, "drive_lag_max_s = 0.02\n" + GOOD).drive_lag_max_s == 0.02
    assert ".drive_lag_max_s = 0.02f," in arm_codegen.table_source(
        described(tmp_path, "drive_lag_max_s = 0.02\n" + GOOD)
    )


def test_a_joints_jerk_limit_overrides_the_arms(tmp_path):
    joint = "[[frame]]\nrange_deg = [-90, 90]\n"
    assert described(tmp_path, GOOD + joint).jerk_max_radps3 == [1e4, 1e4]
    assert described(tmp_path, "jerk_max_radps3 = 2e4\n" + GOOD + joint).jerk_max_radps3 == [2e4, 2e4]
    arm = described(tmp_path, "jerk_max_radps3 = 2e4\n" + GOOD + "jerk_max_radps3 = 3e3\n" + joint)
    assert arm.jerk_max_radps3 == [3e3, 2e4]
    first, second = re.findall(r"\{\{\{.*?\},$", arm_codegen.table_source(arm), re.DOTALL | re.MULTILINE)
    assert first.endswith(" 3000.0f},") and second.endswith(" 20000.0f},")


def test_a_description_is_modified_dh(tmp_path):
    """The torso-to-joint transform of a one-row description equals Rot_x(alpha) Trans(a, 0, d) Rot_z(theta), computed
    with numpy."""
    arm = described(
        tmp_path, GOOD.replace("alpha_deg = 90.0", "alpha_deg = 30.0\na_m = 0.2\nd_m = 0.3\ntheta_deg = 40.0")
    )
    x, z = oracle.rotation([1, 0, 0], np.radians(30)), oracle.rotation([0, 0, 1], np.radians(40))
    expected = oracle.multiply(
        oracle.pose(x, [0, 0, 0]), oracle.multiply(oracle.pose([1, 0, 0, 0], [0.2, 0, 0.3]), oracle.pose(z, [0, 0, 0]))
    )
    (fixed,) = arm.fixed
    assert oracle.pose_distance(oracle.pose(fixed.rotation, fixed.translation_m), expected) < 1e-12
