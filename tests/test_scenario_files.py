"""Scenario files: an error is reported in one line with file, line, key, value and expectation before anything runs,
and valid files are read as written. The expected lines and numbers are computed here from the text."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
import scenario_binding
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from simulation import EXIT_WRONG_USE, FILES, REPOSITORY, SCENARIOS, SHIPPED, call, experiment, run

ffi, lib = scenario_binding.load()

# A scenario with every key that a file can contain, and with all bodies far apart.
SCENE = """\
name: scene
summary: everything that a file can hold
duration_s: 20
arm: {model: hoap3_right, start_deg: [90, -5, 0, -90]}
parameters: {task_blend_s: 2, trace: 1}
tasks:
  upright:
    form: constant
    t_task_m: [0.01, 0, -0.05]
    q_task: [{axis: x, angle_deg: 180}, {axis: z, angle_deg: 45}]
    q_inv: [{axis: x, angle_deg: 180}]
    blend_s: 1.5
robot:
  gripper: {offset_m: [0, 0, 0.02], capture_m: 0.015}
  cup: {radius_m: 0.03, height_m: 0.03, mount_m: [0.05, 0, 0], mount_rotation: [{axis: y, angle_deg: 90}]}
water: {particles: 10, particle_radius_m: 0.005}
objects:
  pipe: {kind: rod, position_m: [0.5, -0.5, 0.03], rotation: [{axis: y, angle_deg: 90}], length_m: 0.3,
         radius_m: 0.01, mass_kg: 0.08, points: {near: -0.1, far: 0.1}}
  post: {kind: stand, position_m: [0.5, -0.5, 0], size_m: [0.1, 0.1, 0.04]}
  winch: {kind: crank, position_m: [0.5, 0.5, 0], length_m: 0.2, radius_m: 0.05, mass_kg: 0.1, points: {end: 0.1}}
people:
  person:
    tracked: true
    position_m: [0.6, -0.1, 0.2]
    rotation: [{axis: y, angle_deg: -90}]
    elbow_m: [0.9, -0.1, 0.1]
    cup: {radius_m: 0.04, height_m: 0.05, mount_m: [0, 0, 0.1]}
    program:
      - {do: rest, name: ready, duration_s: 1, after: operator.started}
      - {do: move, name: there, to_m: [0.03, 0, 0], duration_s: 1}
      - {do: move, to_m: [0.03, 0, 0], turn_deg: [0, 0, 10], duration_s: 1}
      - {do: move, to_m: [0, 0, 0], duration_s: 1}
      - {do: move, by_m: [0, 0.02, 0], duration_s: 1}
      - {do: grip, object: pipe}
      - {do: turn, object: winch, turns: 2, duration_s: 2}
    program_with_recording:
      - {do: play, name: there, position_scale: 0.1, from_s: 1, until_s: 2}
      - {do: move, to_m: [0.03, 0, 0], duration_s: 1}
  helper:
    position_m: [0.6, 0.2, 0.2]
    program:
      - {do: reach, to: pipe.near, duration_s: 1}
      - {do: guide, bring: robot.gripper, to: person.grip}
operator:
  - {do: select, task: upright}
  - {do: start, name: started, at_s: 0.5}
  - {do: gripper, action: close, after: [person.there, helper.done]}
variation: {start_m: 0.01, move_m: 0.02, object_m: [0.01, 0.02, 0], duration_percent: 10}
checks:
  - {name: way, measure: displacement, from: 1, until: {event: person.there, plus_s: 0.1},
     expected_m: [0, 0, 0], at_most: 2}
  - {name: pipe_held, measure: held, object: pipe, by: helper, at_least: 1}
  - {name: caught, measure: water_caught, at_least: 95}
"""


def written(tmp_path: Path, text: str | bytes) -> Path:
    file = tmp_path / "scene.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def changed(old: str, new: str, text: str = SCENE) -> tuple[str, int]:
    """Returns the scene with one replacement, and the line number of the replaced text."""
    assert text.count(old) >= 1, old
    place = text.index(old)
    return text[:place] + new + text[place + len(old) :], text.count("\n", 0, place) + 1


def assert_refused(tmp_path: Path, file: Path, start: str, *words: str) -> None:
    """Checks that the simulator refuses the file with the right status and one line that starts with `start` and
    contains `words`, and that it writes no files."""
    done = run(tmp_path / "out", "--scenario", file)
    assert done.status == EXIT_WRONG_USE, done.stderr
    assert done.stdout == ""
    assert re.fullmatch(r"comanip-sim: [^\x00-\x1f\x7f-\x9f]+\n", done.stderr), f"not one line: {done.stderr!r}"
    assert done.stderr.startswith(f"comanip-sim: {start}"), done.stderr
    assert len(done.stderr) < 2000
    for word in words:
        assert word in done.stderr
    assert not (tmp_path / "out").exists()


# ---- valid files


def test_the_scene_of_these_tests_is_valid(tmp_path):
    scenario_binding.read(written(tmp_path, SCENE))


@pytest.mark.parametrize("name", [*SHIPPED, *(f"{name}_moves" for name in SCENARIOS)])
def test_the_projects_files_run(tmp_path, name):
    file = experiment(name) if name in SHIPPED else REPOSITORY / "tests" / "scenarios" / f"{name}.yaml"
    done = run(tmp_path, "--scenario", file, "--duration", 2)
    assert done.status != EXIT_WRONG_USE, done.stderr
    assert done.summary["ticks"] == 2000
    assert all((tmp_path / name).exists() for name in FILES)


def test_list_shows_each_file_with_its_summary():
    lines = call("--list").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(SHIPPED)
    for line in lines:
        name, summary = line.split(maxsplit=1)
        assert f"\nsummary: {summary}\n" in experiment(name).read_text()


def test_values_are_read_as_written(tmp_path):
    scene = scenario_binding.read(written(tmp_path, SCENE))
    pipe, winch, person, helper = scene.object[0], scene.object[2], scene.person[0], scene.person[1]
    assert [list(point) for point in (pipe.pose.position_m, scene.cup.mount.position_m)] == [
        [0.5, -0.5, 0.03],
        [0.05, 0, 0],
    ]
    assert (pipe.length_m, pipe.radius_m, pipe.mass_kg, winch.radius_m) == (0.3, 0.01, 0.08, 0.05)
    assert [(ffi.string(pipe.point[i].name), pipe.point[i].along_m) for i in range(2)] == [
        (b"near", -0.1),
        (b"far", 0.1),
    ]
    assert (scene.tracked, person.step_count, person.recorded_step_count, scene.operate_count) == (0, 7, 2, 3)
    assert list(person.step[1].displacement_m) == [0.03, 0, 0]
    assert person.step[2].rotation_vector_rad[2] == pytest.approx(math.radians(10), rel=1e-15)
    assert (person.step[4].from_here, person.step[1].from_here) == (True, False)
    assert (person.recorded_step[0].from_s, person.recorded_step[0].until_s) == (1, 2)
    assert (helper.step[0].to.kind, helper.step[0].to.index, helper.step[0].to.point) == (lib.POINT_OBJECT, 0, 0)
    assert (helper.step[1].what.kind, helper.step[1].to.kind) == (lib.POINT_ROBOT_GRIPPER, lib.POINT_PERSON_GRIP)
    awaited = scene.operate[2].start
    events = [ffi.string(scene.events.event[awaited.awaited[i]].name) for i in range(awaited.awaited_count)]
    assert events == [b"person.there", b"helper.done"]
    assert getattr(scene.check[0], "from").s == 1
    assert (ffi.string(scene.events.event[scene.check[0].until.event].name), scene.check[0].until.s) == (
        b"person.there",
        0.1,
    )
    assert (scene.check[1].person, scene.check[1].is_lower_bound, scene.check[1].limit) == (1, True, 1)


def quaternion(*factors: tuple[str, float]) -> np.ndarray:
    """Returns the quaternion w x y z of a product of rotations from left to right, as in Table I."""
    product = Rotation.identity()
    for axis, angle_deg in factors:
        product = product * Rotation.from_euler(axis, angle_deg, degrees=True)
    x, y, z, w = product.as_quat()
    return np.array([w, x, y, z])


def test_rotations_are_products_from_left_to_right(tmp_path):
    define = scenario_binding.read(written(tmp_path, SCENE)).own_task[0].define
    got = np.array([define.q_task.w, define.q_task.x, define.q_task.y, define.q_task.z])
    expected = quaternion(("x", 180), ("z", 45))
    assert abs(got @ expected) == pytest.approx(1, abs=1e-6)
    assert abs(got @ quaternion(("z", 45), ("x", 180))) < 0.8, "the opposite order is another rotation"


# ---- invalid values: text and replacement, path of keys, value shown, part of the message

WRONG = [
    ("radius_m: 0.01", "radius_m: 8 mm", "objects.pipe.radius_m", "8 mm", "a plain number in m, without a unit, from "),
    ("radius_m: 0.01", "radius_m: 0x1", "objects.pipe.radius_m", "0x1", "a plain number in m"),
    ("radius_m: 0.01", 'radius_m: "0.01"', "objects.pipe.radius_m", "0.01", "without quotes"),
    ("radius_m: 0.01", "radius_m: 10", "objects.pipe.radius_m", "10", "in m from 0.001 to 1"),
    ("radius_m: 0.01", "radius_m: .nan", "objects.pipe.radius_m", ".nan", "a plain number"),
    ("radius_m: 0.01", "radius_m: nan", "objects.pipe.radius_m", "nan", "a plain number"),
    ("radius_m: 0.01", "radius_m: .inf", "objects.pipe.radius_m", ".inf", "a plain number"),
    ("radius_m: 0.01", "radius_m: 1e999", "objects.pipe.radius_m", "1e999", "a plain number"),
    ("radius_m: 0.01", "radius_m: thin", "objects.pipe.radius_m", "thin", "a plain number"),
    ("radius_m: 0.01", "radius_m: 0,01", "objects.pipe", "01", "one of the"),
    ("mass_kg: 0.08", "mass_kg: 80 g", "objects.pipe.mass_kg", "80 g", "in kg, without a unit"),
    ("points: {near: -0.1", "points: {near: -10 cm", "objects.pipe.points.near", "-10 cm", "in m, without a unit"),
    ("points: {near: -0.1", "points: {near: -0.2", "objects.pipe.points.near", "-0.2", "from -0.15 to 0.15"),
    ("start_m: 0.01", "start_m: 10 mm", "variation.start_m", "10 mm", "in m, without a unit"),
    ("duration_s: 20", "duration_s: 20 s", "duration_s", "20 s", "in s, without a unit"),
    ("duration_s: 20", "duration_s: 1", "duration_s", "1", "from 2 to 3600"),
    ("{particles: 10", "{particles: 0", "water.particles", "0", "a plain whole number from 1 to 500"),
    ("{particles: 10", "{particles: 10.5", "water.particles", "10.5", "a plain whole number"),
    ("trace: 1", "trace: 0.5", "parameters.trace", "0.5", "a plain whole number from 0 to 1"),
    ("task_blend_s: 2", "task_blend_s: 61", "parameters.task_blend_s", "61", "in s from 0 to 60"),
    ("task_blend_s: 2", "task_blend: 2", "parameters", "task_blend", "did you mean task_blend_s?"),
    ("start_deg: [90, -5", "start_deg: [90, 5", "arm.start_deg[1]", "5", "from -95 to 0 degrees"),
    ("start_deg: [90, -5", "start_deg: [90, x", "arm.start_deg[1]", "x", "a plain number in degrees"),
    ("hoap3_right", "hoap3_left", "arm.model", "hoap3_left", "one of the words hoap3_right"),
    ("radius_m: 0.01", "radus_m: 0.01", "objects.pipe", "radus_m", "did you mean radius_m?"),
    ("kind: rod", "kind: rope", "objects.pipe.kind", "rope", "rod, crank, stand"),
    ("kind: rod", "kind: stand", "objects.pipe", "length_m", "one of the keys"),
    ("size_m: [0.1", "size_m: [-0.1", "objects.post.size_m[0]", "-0.1", "in m from 0.001"),
    ("pipe: {", "Pipe: {", "objects", "Pipe", "a name"),
    ("pipe: {", f"{'p' * 32}: {{", "objects", "p" * 32, "at most 31"),
    ("pipe: {", "robot: {", "objects", "robot", "another name"),
    ("  person:", "  post:", "people", "post", "another name"),
    ("  person:", "  operator:", "people", "operator", "another name"),
    ("tracked: true", "tracked: yes", "people.person.tracked", "yes", "false, true"),
    ("  upright:\n", "  teleop:\n", "tasks", "teleop", "another name"),
    ("form: constant", "form: mirror", "tasks.upright.form", "mirror", "constant, mirrored"),
    ("angle_deg: 45", "angle_rad: 0.7", "tasks.upright.q_task[1]", "angle_rad", "axis, angle_deg"),
    ("axis: z", "axis: w", "tasks.upright.q_task[1].axis", "w", "x, y, z"),
    ("{do: rest", "{do: wait", "people.person.program[0].do", "wait", "rest, move"),
    ("name: ready", "name: done", "people.person.program[0].name", "done", "another name"),
    ("name: ready", "name: 1st", "people.person.program[0].name", "1st", "a name"),
    ("name: there, to_m", "name: ready, to_m", "people.person.program[1].name", "ready", "another name"),
    ("name: started", "name: a b", "operator[1].name", "a b", "a name"),
    ("to_m: [0.03", "to_m: [30 mm", "people.person.program[1].to_m[0]", "30 mm", "in m, without a unit"),
    ("to_m: [0.03", "to_m: [1.6", "people.person.program[1].to_m[0]", "1.6", "in m from -1.5 to 1.5"),
    ("after: operator.started", "after: operator.startd", "people.person.program[0].after", "operator.startd",
     "did you mean operator.started?"),
    ("after: operator.started", "after: nothing", "people.person.program[0].after", "nothing", "events robot.holds, "),
    ("{do: grip, object: pipe", "{do: grip, object: pip", "people.person.program[5].object", "pip",
     "did you mean pipe?"),
    ("{do: grip, object: pipe", "{do: grip, object: post", "people.person.program[5].object", "post",
     "a rod or a crank"),
    ("object: winch, turns", "object: pipe, turns", "people.person.program[6].object", "pipe", "a crank"),
    ("to: pipe.near", "to: pipe.middle", "people.helper.program[0].to", "pipe.middle", "points robot.gripper, "),
    ("until_s: 2", "until_s: 1", "people.person.program_with_recording[0].until_s", "1", "more than from_s"),
    ("task: upright", "task: uprite", "operator[0].task", "uprite", "upright"),
    ("action: close", "action: shut", "operator[2].action", "shut", "open, close"),
    ("measure: held", "measure: holds", "checks[1].measure", "holds", "did you mean held?"),
    ("by: helper", "by: taker", "checks[1].by", "taker", "people person, helper"),
    ("measure: held, object: pipe", "measure: held, object: post", "checks[1].object", "post", "a rod or a crank"),
    ("expected_m: [0", "expected_deg: 1, expected_m: [0", "checks[0]", "expected_deg", "one of the keys"),
    ("name: caught", "name: way", "checks[2].name", "way", "another name"),
    ("from: 1,", "from: 1 s,", "checks[0].from", "1 s", "in s, without a unit"),
    ("plus_s: 0.1", "plus_s: -1", "checks[0].until.plus_s", "-1", "in s from 0"),
    ("summary: everything", f"summary: {'x' * 160}", "summary", "x" * 60 + "...", "at most 159 bytes"),
    ("name: scene", "name: ../scene", "name", "../scene", "a name"),
    ("operator:\n", "operater: 1\noperator:\n", "", "operater", "did you mean operator?"),
]  # fmt: skip

# Missing keys: the replacement, the first line of the changed mapping, the path, and the missing key.
MISSING = [
    ("radius_m: 0.01, ", "", "pipe: {", "objects.pipe", "radius_m"),
    ("position_m: [0.6, 0.2, 0.2]", "tremor_mm: 0", "tremor_mm: 0", "people.helper", "position_m"),
    ("particles: 10, ", "", "water: {", "water", "particles"),
    ("duration_s: 1, after", "after", "{do: rest", "people.person.program[0]", "duration_s"),
    (", duration_s: 1}", "}", "{do: move", "people.person.program[1]", "duration_s"),
    ("turns: 2, ", "", "{do: turn", "people.person.program[6]", "turns"),
    ("measure: held, ", "", "{name: pipe_held", "checks[1]", "measure"),
    ("object: pipe, by", "by", "{name: pipe_held", "checks[1]", "object"),
    ("expected_m: [0, 0, 0], ", "", "{name: way", "checks[0]", "expected_m"),
    (", at_least: 1}", "}", "{name: pipe_held", "checks[1]", "at_least or at_most"),
    ("to_m: [0, 0, 0], ", "", "{do: move, duration_s", "people.person.program[3]",
     "at least one of to_m, by_m and turn_deg"),
    ("by_m: [0,", "to_m: [0, 0, 0], by_m: [0,", "{do: move, to_m: [0, 0, 0], by_m", "people.person.program[4]",
     "not both"),
    ("name: scene", "tracking: {}", "tracking: {}", "the scenario", "name"),
]  # fmt: skip

# Files that are malformed as a whole: the text, the line reported, and part of the error message.
SPOILT = {
    "empty": ("", 1, "the file is empty"),
    "comment": ("# nothing\n", 1, "the file is empty"),
    "word": ("pour\n", 1, "a mapping of keys at the top level"),
    "list": ("\n- a\n- b\n", 2, "a mapping of keys at the top level"),
    "syntax": ("name: scene\narm: [\n", None, "expected YAML in UTF-8"),
    "tab": ("name: scene\n\tarm: 1\n", 2, "expected YAML in UTF-8"),
    "latin": (b"name: \xe4\n", 1, "expected YAML in UTF-8"),
    "binary": (bytes(range(256)), 1, "expected YAML in UTF-8"),
    "documents": (SCENE + "---\n" + SCENE, SCENE.count("\n") + 1, "one document"),
    "anchor": (*changed("name: scene", "name: &a scene"), "'&a': expected the value alone"),
    "alias": (*changed("  person:\n", "  person: &p\n"), "'&p': expected the value alone"),
    "unknown alias": (*changed("name: scene", "name: *a"), "'*a'"),
    "tag": (*changed("duration_s: 20", "duration_s: !!float 20"), "tags are not supported"),
    "own tag": (*changed("name: scene", "name: !scene scene"), "'!scene'"),
    "list as key": (*changed("name: scene", "? [a, b]\n: c\nname: scene"), "a name as key"),
    "escape": (*changed("summary: every", 'summary: "a\\e[31m" #'), "without control characters"),
    "zero": (*changed("summary: every", 'summary: "a\\0b" #'), "without control characters"),
    "newline": (*changed("summary: every", 'summary: "a\\nb" #'), "without control characters"),
    "next line": (*changed("summary: every", 'summary: "a\\Nb" #'), "without control characters"),
    "line separator": (*changed("summary: every", 'summary: "a\\Lb" #'), "without control characters"),
    "long": (*changed("summary: every", "summary: &a " + 40 * "\N{EURO SIGN}" + "\nname: x #"), "'&a'"),
    "long and wrong": (*changed("summary: every", 'summary: "' + 40 * "\N{EURO SIGN}" + '\\a" #'), "in one line"),
    "control in a tag": (*changed("name: scene", "name: !a%c2%9b scene"), "'!a': expected the value alone"),
    "control in a key": (*changed("name: scene", '"a\\rb": 1\nname: scene'), "without control characters"),
    "twice": (*changed("duration_s: 20", "name: again"), "'name': expected each key once; line 1 has it already"),
    "object twice": (*changed("post: {", "pipe: {"), "objects 'pipe': expected each key once; line 18 has it already"),
    "deep": ("a: " + 30 * "[" + 30 * "]" + "\n", 1, "at most 12 levels"),
    "crowded": ("name: scene\n" + "".join(f"a{i}: 1\n" for i in range(70)), 1, "at most 64 keys"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "keys", "value", "words"), WRONG, ids=[new for _, new, *_ in WRONG])
def test_wrong_value(tmp_path, old, new, keys, value, words):
    text, line = changed(old, new)
    file = written(tmp_path, text)
    assert_refused(tmp_path, file, f"{file}:{line}: {keys}{' ' if keys else ''}'{value}': expected ", words)


@pytest.mark.parametrize(("old", "new", "mapping", "keys", "missing"), MISSING, ids=[row[-1] for row in MISSING])
def test_missing_key(tmp_path, old, new, mapping, keys, missing):
    text, _ = changed(old, new)
    file = written(tmp_path, text)
    line = text.count("\n", 0, text.index(mapping)) + 1
    assert_refused(tmp_path, file, f"{file}:{line}: {keys}: expected ", missing)


@pytest.mark.parametrize("name", SPOILT)
def test_malformed_file(tmp_path, name):
    text, line, words = SPOILT[name]
    file = written(tmp_path, text)
    assert_refused(tmp_path, file, f"{file}:" if line is None else f"{file}:{line}: ", words)


def test_no_such_file(tmp_path):
    missing = tmp_path / "missing.yaml"
    assert_refused(tmp_path, missing, f"{missing}: expected a scenario file: No such file or directory")
    assert_refused(tmp_path, tmp_path, f"{tmp_path}: expected a scenario file: Is a directory")
    assert_refused(tmp_path, Path("/dev/zero"), "/dev/zero: expected a scenario file of at most 1 MB")
    huge = written(tmp_path, SCENE + 1_000_000 * "#")
    assert_refused(tmp_path, huge, f"{huge}: expected a scenario file of at most 1 MB")
    long_path = "x/" * 300
    assert_refused(
        tmp_path, Path(long_path), f"--scenario '{long_path[:200]}...': expected a path of at most 511 bytes"
    )


def many(count: int, line: str) -> str:
    return "".join(line.format(i) + "\n" for i in range(count))


TOO_MANY = {
    "steps": ("    program:\n", "    program:\n" + many(34, "      - {{do: rest, duration_s: 1}}"),
              "people.person.program",
              "40 items; there are 41"),
    "commands": ("operator:\n", "operator:\n" + many(38, "  - {{do: clutch}}"), "operator", "40 items; there are 41"),
    "checks": ("checks:\n", "checks:\n" + many(22, "  - {{name: c{}, measure: clearance, at_least: 0}}"), "checks",
               "24 items; there are 25"),
    "objects": ("objects:\n", "objects:\n" + many(6, "  o{}: {{kind: stand}}"), "objects", "8 objects"),
    "points": ("{near: -0.1", "{a: 0, b: 0, c: 0, near: -0.1", "objects.pipe.points", "4 points"),
    "people": ("people:\n", "people:\n  one: {position_m: [1, 1, 1]}\n", "people", "2 people"),
    "tasks": ("tasks:\n", "tasks:\n" + many(8, "  t{}: {{form: constant}}"), "tasks", "8 tasks"),
    "events": ("after: operator.started", "after: [operator.started, robot.holds, robot.lost, robot.closed]",
               "people.person.program[0].after", "3 items; there are 4"),
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_MANY)
def test_too_many(tmp_path, name):
    old, new, keys, words = TOO_MANY[name]
    text, line = changed(old, new)
    file = written(tmp_path, text)
    line += 1 if new.count("\n") else 0  # the list begins one line below its key
    assert_refused(tmp_path, file, f"{file}:{line}: {keys}: expected at most ", words)


@pytest.mark.parametrize(
    ("old", "new", "keys", "words"),
    [
        ("tracked: true", "tracked: false", "people", "one person with tracked: true; there are 0"),
        ("  helper:\n", "  helper:\n    tracked: true\n", "people", "one person with tracked: true; there are 2"),
        ("  - {do: start, name: started, at_s: 0.5}\n", "", "operator", "do: start"),
        ("cup: {radius_m: 0.03, height", "cap: {radius_m: 0.03, height", "robot 'cap'", "did you mean cup?"),
        ("    cup: {radius_m: 0.04", "    elbow: {radius_m: 0.04", "people.person 'elbow'", "did you mean elbow_m?"),
    ],
)
def test_keys_that_need_each_other(tmp_path, old, new, keys, words):
    text, _ = changed(old, new)
    text = text.replace("after: operator.started", "at_s: 1") if "do: start" in words else text
    file = written(tmp_path, text)
    with pytest.raises(ValueError, match=re.escape(words)) as refusal:
        scenario_binding.read(file)
    assert re.match(re.escape(str(file)) + r":\d+: " + re.escape(keys) + ": expected ", str(refusal.value))


def without(section: str) -> str:
    """Returns the scene without one of its top-level sections."""
    return re.sub(rf"^{section}:.*\n(?:[ ].*\n)*", "", SCENE, flags=re.MULTILINE)


def test_a_checks_subject_must_exist(tmp_path):
    with pytest.raises(ValueError, match=r"checks\[2\].measure 'water_caught': expected water in the scenario"):
        scenario_binding.read(written(tmp_path, without("water")))
    with pytest.raises(ValueError, match=r": water: expected a cup that holds it"):
        scenario_binding.read(written(tmp_path, changed("  cup: {radius_m: 0.03", "# {")[0]))
    with pytest.raises(ValueError, match=r"checks\[2\].measure 'water_caught': expected a person with a cup"):
        scenario_binding.read(written(tmp_path, changed("    cup: {radius_m: 0.04", "# {")[0]))
    with pytest.raises(ValueError, match=r"object 'pipe': expected one of the objects: there are none"):
        scenario_binding.read(written(tmp_path, without("objects")))


@pytest.mark.parametrize("section", ["arm", "people", "operator"])
def test_a_missing_section(tmp_path, section):
    text = without(section).replace("after: operator.started", "at_s: 1")
    with pytest.raises(ValueError, match=rf":1: the scenario: expected a key {section} in it"):
        scenario_binding.read(written(tmp_path, text))


@pytest.mark.parametrize("section", ["arm", "parameters", "tasks", "robot", "water", "objects", "people", "variation",
                                     "tracking"])  # fmt: skip
def test_a_section_of_the_wrong_form(tmp_path, section):
    for wrong in ("[1, 2]", "5"):
        with pytest.raises(ValueError, match=rf":1: {section}(| '5'): expected a mapping"):
            scenario_binding.read(written(tmp_path, f"{section}: {wrong}\n" + without(section)))


@settings(
    max_examples=300, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_any_damage_is_accepted_or_refused_with_one_line(tmp_path, data):
    """A file with random damage is either accepted or refused with a one-line message. The sanitiser ends the process
    at the first memory error or undefined behaviour in the C code."""
    text = without("water").replace("  - {name: caught, measure: water_caught, at_least: 95}\n", "")
    for _ in range(data.draw(st.integers(1, 3))):
        begin = data.draw(st.integers(0, len(text)))
        end = min(len(text), begin + data.draw(st.integers(0, 12)))
        insert = data.draw(
            st.sampled_from(["", "[", "]", "{", "}", ": ", ", ", "-", "\n", "1e9", "x", "'", '"', "\0", "~"])
        )
        text = text[:begin] + insert + text[end:]
    file = written(tmp_path, text)
    try:
        scenario_binding.read(file)
    except ValueError as refusal:
        assert re.fullmatch(re.escape(str(file)) + r":[^\x00-\x1f]*expected [^\x00-\x1f]+", str(refusal))


# ---- impossible combinations of valid values


def refusal_of(tmp_path: Path, *changes: tuple[str, str]) -> str:
    """Returns the reader's message about the scene with the given changes, or "" if the scene is accepted."""
    text = SCENE
    for old, new in changes:
        text, _ = changed(old, new, text)
    try:
        scenario_binding.read(written(tmp_path, text))
    except ValueError as error:
        return str(error)
    return ""


def test_an_object_inside_another(tmp_path):
    """The rod, with a radius of 10 mm and its axis at z = 30 mm, lies on the stand, whose top is at 20 mm. When the
    stand is raised by more than 1 mm, the overlap is refused."""
    for raised_m in (0.0005, 0.0009):
        assert refusal_of(tmp_path, ("[0.5, -0.5, 0]", f"[0.5, -0.5, {raised_m}]")) == ""
    for raised_m in (0.0015, 0.004):
        text = refusal_of(tmp_path, ("[0.5, -0.5, 0]", f"[0.5, -0.5, {raised_m}]"))
        found = re.search(rf"objects.post.position_m '\[0.5, -0.5, {raised_m}\]'.* post is (.*) mm inside pipe", text)
        assert 1e3 * raised_m - 0.06 <= float(found.group(1)) <= 1e3 * raised_m + 0.36


# The end effector is at (0.136, -0.121, 0.014) m and points forward, with its cup 50 mm above it. The person's hand
# points backward, with its cup 100 mm in front of it, open towards the robot.
OVERLAPS = [
    ("[0.5, 0.5, 0]", "[0.45, -0.5, 0.03]", "objects.winch.position_m", "winch", "pipe"),
    ("[0.5, -0.5, 0.03]", "[0.15, -0.12, 0.07]", "objects.pipe.position_m", "pipe", "the robot's cup"),
    ("[0.5, -0.5, 0.03]", "[0, 0, 0.05]", "objects.pipe.position_m", "pipe", "the robot's torso"),
    ("[0.6, -0.1, 0.2]", "[0.6, -0.5, 0.05]", "objects.pipe.position_m", "pipe", "person's cup"),
    ("[0.6, -0.1, 0.2]", "[0.25, -0.12, 0.08]", "robot.cup.mount_m", "the robot's cup", "person's cup"),
    ("[0.6, -0.1, 0.2]", "[0.1, -0.1, 0]", "people.person.position_m", "person's hand", "the robot's forearm"),
    ("[0.6, -0.1, 0.2]", "[0, 0, 0.3]", "people.person.position_m", "person's hand", "the robot's head"),
    ("mount_m: [0.05, 0, 0]", "mount_m: [0, 0, -0.15]", "robot.cup.mount_m", "the robot's cup",
     "the robot's upper_arm"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "what", "inside"), OVERLAPS, ids=[f"{r[3]} in {r[4]}" for r in OVERLAPS])
def test_overlapping_bodies(tmp_path, old, new, key, what, inside):
    pattern = rf"scene.yaml: {re.escape(key)} '\[.*\]': expected .*; {what} is [0-9.]+ mm inside {inside}"
    assert re.search(pattern, refusal_of(tmp_path, (old, new)))


def test_cups_of_two_people(tmp_path):
    """Two cups stand side by side, each with an outer radius of 42 mm."""
    cup = "{radius_m: 0.04, height_m: 0.05, mount_m: [0, 0, 0.1]}"
    for z_m, is_apart in ((0.2 + 2 * 0.042 + 0.001, True), (0.2 + 2 * 0.042 - 0.003, False)):
        other = f"  helper:\n    cup: {cup}\n    rotation: [{{axis: y, angle_deg: -90}}]\n"
        text = refusal_of(tmp_path, ("  helper:\n", other), ("[0.6, 0.2, 0.2]", f"[0.6, -0.1, {z_m}]"))
        assert (text == "") == is_apart, text
        assert is_apart or "people.helper.cup.mount_m" in text and "helper's cup is" in text


def test_an_object_held_by_the_robot_is_in_its_gripper(tmp_path):
    """The gripper's middle is 20 mm in front of the end effector. The robot can hold an object up to 15 mm away from
    there."""
    hand_m = np.array([0.136, -0.1206743, 0.0144224])
    for offset_mm, is_held in ((0, True), (14.9, True), (15.1, False)):
        x, y, z = hand_m + [0.02, 0, -1e-3 * offset_mm]
        text = refusal_of(
            tmp_path, ("[0.5, -0.5, 0.03]", f"[{x}, {y}, {z}]"), ("mass_kg: 0.08", "mass_kg: 0.08, held_by: robot")
        )
        assert (text == "") == is_held, text
        assert is_held or re.search(r"objects.pipe.held_by 'robot': expected .* 15 mm .*; it is 15.1 mm away", text)


@pytest.mark.parametrize("program", ["program", "program_with_recording"])
def test_nobody_moves_faster_than_five_metres_per_second(tmp_path, program):
    """The peak speed of a minimum-jerk move is 15/8 of the mean speed (Flash and Hogan, 1985). The distance of the last
    move follows from the hand's position after the steps before it: a rest keeps the position, and a move with by_m
    adds to it."""
    way_m = 0.3 - 0.03 + 0.1
    least_s = 15 / 8 * way_m / 5
    place = "      - {do: rest, name: ready" if program == "program" else "      - {do: play"
    for duration_s, is_slow in ((1.001 * least_s, True), (0.999 * least_s, False)):
        steps = (
            "      - {do: move, to_m: [0.03, 0, 0], duration_s: 1}\n"
            "      - {do: move, by_m: [-0.1, 0, 0], duration_s: 1}\n"
            f"      - {{do: rest, duration_s: 1}}\n      - {{do: move, to_m: [0.3, 0, 0], duration_s: {duration_s}}}\n"
        )
        text = refusal_of(tmp_path, (place, steps + place))
        assert (text == "") == is_slow, text
        assert (
            is_slow
            or f"scene.yaml: people.person.{program}[3].duration_s '{duration_s:.6g}': expected more time" in text
        )


def test_nobody_cranks_faster_than_five_metres_per_second(tmp_path):
    """duration_s is the time of one turn, in which the hand follows the handle around a circle of 50 mm radius."""
    least_s = 2 * math.pi * 0.05 / 5
    for duration_s, is_slow in ((1.001 * least_s, True), (0.999 * least_s, False)):
        text = refusal_of(tmp_path, ("turns: 2, duration_s: 2", f"turns: 2, duration_s: {duration_s}"))
        assert (text == "") == is_slow, text
        assert is_slow or "people.person.program[6].duration_s" in text and "expected more time" in text


@pytest.mark.parametrize(("key", "gyration_m"), [("stiffness_Npm", 1.0), ("stiffness_Nmprad", 0.06)])
@pytest.mark.parametrize("damping_ratio", [0.05, 0.7, 3.0])
def test_a_hand_is_stable_at_two_milliseconds(tmp_path, key, gyration_m, damping_ratio):
    """A hand of 0.1 kg is accepted up to the stiffness at which the step v += h (-w^2 x - 2 d w v), x += h v becomes
    unstable, as its eigenvalues show."""
    h = 2e-3

    def radius(stiffness: float) -> float:
        w = math.sqrt(stiffness / (0.1 * gyration_m**2))
        v_row = np.array([-h * w**2, 1 - 2 * h * damping_ratio * w])
        return np.abs(np.linalg.eigvals([[1 + h * v_row[0], h * v_row[1]], v_row])).max()

    low, high = 1e-3, 1e9
    for _ in range(100):
        low, high = (middle, high) if radius(middle := math.sqrt(low * high)) < 1 else (low, middle)
    other = "stiffness_Nmprad: 0.02" if key == "stiffness_Npm" else "stiffness_Npm: 20"
    for stiffness, is_stable in ((0.99 * low, True), (1.01 * low, False)):
        hand = (
            f"tracked: true\n    mass_kg: 0.1\n    damping_ratio: {damping_ratio}\n"
            f"    {other}\n    {key}: {stiffness:.6g}"
        )
        text = refusal_of(tmp_path, ("tracked: true", hand))
        assert (text == "") == is_stable, text
        assert is_stable or f"people.person.{key} '{stiffness:.6g}': expected {key} below" in text


def test_nobody_goes_further_than_an_arm(tmp_path):
    step = "      - {do: move, by_m: [0, 0.02, 0], duration_s: 1}\n"
    for times, is_near in ((1, True), (2, False)):
        text = refusal_of(tmp_path, (step, times * step.replace("0.02", "0.8")))
        assert (text == "") == is_near, text
        assert is_near or "people.person.program[5] '[0, 1.6, 0]': expected a position at most 1.5 m" in text


def test_people_start_near_the_torso(tmp_path):
    assert refusal_of(tmp_path, ("[0.6, 0.2, 0.2]", "[1.9, 0.5, 0]")) == ""
    text = refusal_of(tmp_path, ("[0.6, 0.2, 0.2]", "[1.9, 0.7, 0]"))
    assert "people.helper.position_m '[1.9, 0.7, 0]': expected at most 2 m" in text


def test_water_fits_its_cup(tmp_path):
    """The spheres may fill at most 64 % of the cup's volume (random close packing). The message also advises fewer
    particles or an upright cup where a smaller amount would fall over the rim, as everything does from a cup that is
    upside down."""
    most = math.floor(0.64 * math.pi * 0.03**2 * 0.03 / (4 / 3 * math.pi * 0.005**3))
    text = refusal_of(tmp_path, ("particles: 10", f"particles: {most + 1}"))
    assert f"water.particles '{most + 1}': expected at most {most}," in text
    text = refusal_of(tmp_path, ("particle_radius_m: 0.005", "particle_radius_m: 0.03"))
    assert "water.particle_radius_m '0.03': expected less than the robot cup's 0.03 m" in text
    text = refusal_of(
        tmp_path, ("mount_rotation: [{axis: y, angle_deg: 90}]", "mount_rotation: [{axis: y, angle_deg: -90}]")
    )
    assert re.search("water.particles '10': expected fewer, or an upright cup", text)


# ---- variation by seed


def varied(scene: object, seed: int) -> object:
    """Returns a copy of the scenario with the variation of the given seed."""
    copy = ffi.new("scenario_t *", scene[0])
    lib.scenario_vary(copy, seed)
    return copy


def bytes_of(struct: object) -> bytes:
    return bytes(ffi.buffer(struct if ffi.typeof(struct).kind == "pointer" else ffi.addressof(struct)))


DRY = without("water").replace("  - {name: caught, measure: water_caught, at_least: 95}\n", "")


@pytest.fixture
def scene(tmp_path) -> object:
    return scenario_binding.read(written(tmp_path, DRY))


def test_seed_0_varies_nothing_and_other_seeds_repeat(scene):
    assert bytes_of(varied(scene, 0)) == bytes_of(scene)
    assert bytes_of(varied(scene, 1)) == bytes_of(varied(scene, 1))
    assert len({bytes_of(varied(scene, seed)) for seed in (0, 1, 2, 2**32 + 1, 2**63)}) == 5


def test_without_a_variation_nothing_varies(tmp_path):
    scene = scenario_binding.read(written(tmp_path, re.sub(r"^variation:.*\n", "", DRY, flags=re.MULTILINE)))
    assert bytes_of(varied(scene, 5)) == bytes_of(scene)


def test_moves_to_one_position_share_its_variation(scene):
    was = scene.person[0]
    for seed in range(1, 20):
        now = varied(scene, seed).person[0]
        there, again, home = (np.array(list(now.step[i].displacement_m)) for i in (1, 2, 3))
        assert (there == again).all()
        assert (home != 0).all(), "the home position varies as well"
        assert not np.isclose(there - [0.03, 0, 0], home).any(), "each position varies on its own"
        assert list(now.step[4].displacement_m) == [0, 0.02, 0], "a move by_m has no variation of its own"
        assert list(now.step[2].rotation_vector_rad) == list(was.step[2].rotation_vector_rad)
        assert now.recorded_step[0].position_scale == 0.1


def test_objects_stay_together_and_with_the_gripper(tmp_path):
    text, _ = changed("[0.5, -0.5, 0.03]", "[0.156, -0.12, 0.014]", DRY)
    scene = scenario_binding.read(written(tmp_path, changed("mass_kg: 0.08", "mass_kg: 0.08, held_by: robot", text)[0]))
    for seed in range(1, 20):
        now = varied(scene, seed)
        places = [[np.array(list(s.object[i].pose.position_m)) for i in range(3)] for s in (scene, now)]
        held, stand, crank = np.subtract(places[1], places[0])
        assert (held == 0).all()
        np.testing.assert_allclose(stand, crank, atol=1e-15)
        assert (np.abs(stand) <= [0.01, 0.02, 0]).all() and (stand[:2] != 0).all()


def test_draws_are_uniform_and_within_bounds(scene):
    """The Kolmogorov-Smirnov distance of n draws from the uniform distribution exceeds 1.95 / sqrt(n) only once in a
    thousand samples. The seeds are fixed, so the test does not fail at random."""
    count, before = 400, scene.person[0]
    draws = {name: [] for name in ("start", "elbow", "move", "recorded", "duration", "turn")}
    for seed in range(1, count + 1):
        now = varied(scene, seed)
        person = now.person[0]
        draws["start"].append((person.start.position_m[1] - before.start.position_m[1]) / 0.01)
        draws["elbow"].append((person.elbow_m[1] - before.elbow_m[1]) / 0.01)
        draws["move"].append(person.step[1].displacement_m[2] / 0.02)
        draws["recorded"].append(person.recorded_step[1].displacement_m[2] / 0.02)
        draws["duration"].append((person.step[0].duration_s - 1) / 0.1)
        draws["turn"].append((person.step[6].duration_s / 2 - 1) / 0.1)
        assert bytes_of(now.person[1].start) == bytes_of(scene.person[1].start), "only the tracked person varies"
    np.testing.assert_allclose(draws["elbow"], draws["start"], atol=1e-12)
    steps = np.arange(count + 1) / count
    for name, values in draws.items():
        share = (np.sort(values) + 1) / 2
        assert share[0] >= -1e-12 and share[-1] <= 1 + 1e-12, name
        assert max(np.abs(share - steps[1:]).max(), np.abs(share - steps[:-1]).max()) < 1.95 / math.sqrt(count), name
    for one, other in (("move", "recorded"), ("move", "duration"), ("start", "move"), ("duration", "turn")):
        assert abs(np.corrcoef(draws[one], draws[other])[0, 1]) < 4 / math.sqrt(count), (one, other)


def test_an_additional_step_does_not_change_other_draws(scene, tmp_path):
    step = "      - {do: rest, name: ready"
    longer = scenario_binding.read(written(tmp_path, DRY.replace(step, "      - {do: rest, duration_s: 1}\n" + step)))
    one, other = varied(scene, 7), varied(longer, 7)
    assert other.person[0].step_count == one.person[0].step_count + 1
    for number in (0, 1):
        was, now = one.person[0].recorded_step[number], other.person[0].recorded_step[number]
        assert list(was.displacement_m) == list(now.displacement_m) and was.duration_s == now.duration_s
    assert one.person[1].step[0].duration_s == other.person[1].step[0].duration_s
    assert bytes_of(one.person[0].start) == bytes_of(other.person[0].start)
    assert bytes_of(one.object[0].pose) == bytes_of(other.object[0].pose)


# ---- documentation

MAPPINGS = [
    ("name: scene", "qqqqqqqqqqqq: 1\nname: scene"),
    ("{model", "{qqqqqqqqqqqq: 1, model"),
    ("    form:", "    qqqqqqqqqqqq: 1\n    form:"),
    ("{offset_m", "{qqqqqqqqqqqq: 1, offset_m"),
    ("cup: {", "cup: {qqqqqqqqqqqq: 1, "),
    ("water: {", "water: {qqqqqqqqqqqq: 1, "),
    *((f"{kind},", f"{kind}, qqqqqqqqqqqq: 1,") for kind in ("kind: rod", "kind: crank", "kind: stand")),
    ("    tracked", "    qqqqqqqqqqqq: 1\n    tracked"),
    *((f"{{do: {do}", f"{{qqqqqqqqqqqq: 1, do: {do}") for do in ("rest", "move", "play", "reach", "guide", "grip",
                                                                 "turn",
                                                               "select", "start", "gripper")),
    ("variation: {", "variation: {qqqqqqqqqqqq: 1, "),
    ("variation: {", "tracking: {qqqqqqqqqqqq: 1}\nvariation: {"),
    ("{event", "{qqqqqqqqqqqq: 1, event"),
    ("measure: displacement", "qqqqqqqqqqqq: 1, measure: displacement"),
    ("measure: held", "qqqqqqqqqqqq: 1, measure: held"),
    ("kind: rod", "kind: qqqqqqqqqqqq"),
    ("do: rest", "do: qqqqqqqqqqqq"),
    ("do: select", "do: qqqqqqqqqqqq"),
    ("measure: held", "measure: qqqqqqqqqqqq"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new"), MAPPINGS, ids=[new.strip()[:40] for _, new in MAPPINGS])
def test_each_key_and_word_is_documented(tmp_path, old, new):
    """Every key and word that the reader accepts is documented in docs/scenario-files.md."""
    text = (REPOSITORY / "docs" / "scenario-files.md").read_text()
    known = re.search(r"'qqqqqqqqqqqq': expected one of the (?:keys|words) (.*)", refusal_of(tmp_path, (old, new)))
    for word in known.group(1).split(", "):
        assert f"`{word}`" in text or f"`{word}:" in text, word
