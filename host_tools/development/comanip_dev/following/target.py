"""Algorithm 1 in double: where the robot's hand shall be for each displacement and turn of the person's, both about the
torso's axes.

With the robot's hand at the start (r_0, p_0) and q_task = (r_k, t_k): the virtual hand turns as the person's does from
r_0 r_inv and moves by the same displacement from p_0; the target's rotation is r = r_virtual conj(r_k), its position
p_virtual - R(r) t_k. Mirrored tasks add twice the forward displacement to t_k's z.
"""

from __future__ import annotations

import numpy as np
from comanip._core import lib
from comanip.core.cooperation import enumerators

from comanip_dev.following import rotations

TASKS = {
    name: number for name, number in enumerators("task_id_t", "TASK_").items() if name in ("pour", "teleop", "mirror")
}


def _vector(v) -> np.ndarray:
    return np.array([v.x, v.y, v.z], float)


def _quaternion(q) -> np.ndarray:
    rotation = np.array([q.w, q.x, q.y, q.z], float)
    return rotation / np.linalg.norm(rotation)


def targets(
    task: str, start_m: np.ndarray, start_rotation: np.ndarray, displacement_m: np.ndarray, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """start_m (3,), start_rotation (4,): the robot's hand; displacement_m (N, 3), turn (N, 4): the person's. Gives
    positions (N, 3) and rotations (N, 4)."""
    definition = lib.task_table[TASKS[task]]
    relation = rotations.conjugate(_quaternion(definition.q_task))
    virtual = rotations.multiply(start_rotation, _quaternion(definition.q_inv))
    rotation = rotations.multiply(rotations.multiply(turn, virtual), relation)
    t_k = np.tile(_vector(definition.t_task_m), (len(turn), 1))
    if definition.form == lib.TASK_FORM_MIRRORED:
        t_k[:, 2] += 2.0 * displacement_m[:, 0]
    return start_m + displacement_m - rotations.rotate(rotation, t_k), rotation
