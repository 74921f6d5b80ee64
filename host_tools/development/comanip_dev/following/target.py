"""Implements Algorithm 1 in double precision. Computes the end effector's target for each displacement and rotation of
the person's hand, both in torso axes.

Let the end effector start with the rotation r_0 at the position p_0. The task defines the rotations r_k and r_inv
(q_task and q_inv in tasks.toml) and the displacement t_k (t_task). The virtual hand starts with the rotation r_0 r_inv
at p_0, and moves by the rotation and the displacement of the person's hand. The target has the rotation
r = r_virtual conj(r_k) and the position p_virtual - R(r) t_k. Mirrored tasks add twice the forward displacement to the
z component of t_k.
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
    """Returns the targets' positions (N, 3) and rotations (N, 4). start_m (3,), start_rotation (4,): start pose of the
    end effector. displacement_m (N, 3), turn (N, 4): motion of the person's hand."""
    definition = lib.task_table[TASKS[task]]
    relation = rotations.conjugate(_quaternion(definition.q_task))
    virtual = rotations.multiply(start_rotation, _quaternion(definition.q_inv))
    rotation = rotations.multiply(rotations.multiply(turn, virtual), relation)
    t_k = np.tile(_vector(definition.t_task_m), (len(turn), 1))
    if definition.form == lib.TASK_FORM_MIRRORED:
        t_k[:, 2] += 2.0 * displacement_m[:, 0]
    return start_m + displacement_m - rotations.rotate(rotation, t_k), rotation
