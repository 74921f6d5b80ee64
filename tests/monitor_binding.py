"""The monitors as a Python library, ``ffi, lib = load()``: with SCENE in the place of ODE. Needs build/generated."""

from __future__ import annotations

import functools
import subprocess
import tempfile
from pathlib import Path

import cffi
from c_declarations import declarations
from sim_binding import COMPILE, FIRMWARE, GENERATED, REPOSITORY

PARTS = (
    "common/events", "common/names", "common/random", "common/rigid_pose", "common/solve_3x3", "hand/minimum_jerk", "hand/tremor",
    "monitors/bus_delays", "monitors/check_window", "monitors/contact_monitor", "monitors/delay_fit",
    "monitors/latency", "monitors/measure", "monitors/measurement",
    "monitors/physical_state", "monitors/reach", "monitors/rest_monitor", "monitors/rest_noise",
    "monitors/scenario_monitor", "monitors/tracking", "output/text_number", "output/trace_csv",
    "robot/position_jacobian", "robot/robot_model",
)  # fmt: skip

# A scene that gives each question an answer of its own.
SCENE = """
#include "sim/scene/scene.h"
void scene_hand(const scene_t *s, size_t person, rigid_pose_t *hand) {
    (void)s;
    *hand = (rigid_pose_t){{10.0 + (double)person, 0.25, -0.5}, {1.0, 0.0, 0.0, 0.0}};
}
void scene_hand_force_N(const scene_t *s, size_t person, double force_N[3]) {
    (void)s;
    for (int k = 0; k < 3; k++) { force_N[k] = (double)(k + 1) * (1.0 + (double)person); }
}
void scene_object(const scene_t *s, size_t object, rigid_pose_t *pose) {
    (void)s;
    *pose = (rigid_pose_t){{20.0 + (double)object, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}};
}
double scene_crank_turns(const scene_t *s, size_t object) { (void)s; return 0.5 + (double)object; }
bool scene_holds(const scene_t *s, size_t holder, size_t object) { (void)s; return holder == object % 3; }
double scene_gripper_opening(const scene_t *s) { (void)s; return 0.75; }
double scene_gripper_force_N(const scene_t *s) { (void)s; return 8.5; }
void scene_robot_cup(const scene_t *s, rigid_pose_t *cup) {
    (void)s;
    *cup = (rigid_pose_t){{1.0, 2.0, 3.0}, {1.0, 0.0, 0.0, 0.0}};
}
water_count_t scene_water(const scene_t *s) { (void)s; return (water_count_t){50, 6, 4, 11}; }
"""


@functools.cache
def load() -> tuple[cffi.FFI, object]:
    """The monitors as a library, with SCENE in the place of ODE. Compiled anew in each test run."""
    ffi = cffi.FFI()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ffi.cdef(declarations((REPOSITORY / "sim" / f"{part}.h" for part in PARTS), f"-I{GENERATED}"))
        (folder / "scene.c").write_text(SCENE)
        sources = [str(REPOSITORY / "sim" / f"{part}.c") for part in PARTS] + [str(folder / "scene.c")]
        sources += sorted(str(file) for file in FIRMWARE if file.name != "main.c")
        library = folder / "monitors.so"
        command = [*COMPILE, "-shared", f"-I{REPOSITORY}", *sources, "-lm", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")
        return ffi, ffi.dlopen(str(library))
