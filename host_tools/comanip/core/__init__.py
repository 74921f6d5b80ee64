"""Provides the firmware's mathematics on numpy arrays. The C code is that of the microcontroller,
compiled for this machine.

Arrays are float32. A dual quaternion is a row of 8 components, [w x y z | w' x' y' z']. A pose is r + eps 1/2 t r with
t in metres. A dual quaternion and its negative represent the same pose. Arguments are checked: a wrong shape or type,
an unknown name, a value that is not finite, or a pose that deviates from unit norm by more than 1e-4 raises a
ValueError, which names the argument and the reason.
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
