"""Provides the firmware's mathematics on numpy arrays. The C code is that of the microcontroller, compiled for this
machine.

Arrays are float32. A dual quaternion is a row of 8 components, [w x y z | w' x' y' z']. A pose with the rotation r and
the translation t in metres is the dual quaternion r + eps 1/2 t r. A dual quaternion and its negative represent the
same pose. All functions check their arguments. They raise a ValueError that names the argument and the reason if a
shape, type or name is wrong, if a value is not finite, or if a pose deviates from unit norm by more than 1e-4.
"""

from comanip.core.arm import Arm, arms
from comanip.core.batch import (
    conjugate,
    decompositional_multiply,
    forward_kinematics,
    joint_velocity,
    multiply,
    normalise,
    pose_from_matrix,
    pose_jacobian,
)
from comanip.core.cooperation import Cooperation

__all__ = [
    "Arm",
    "Cooperation",
    "arms",
    "conjugate",
    "decompositional_multiply",
    "forward_kinematics",
    "joint_velocity",
    "multiply",
    "normalise",
    "pose_from_matrix",
    "pose_jacobian",
]
