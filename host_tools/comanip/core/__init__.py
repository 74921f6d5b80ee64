"""The firmware's mathematics on numpy arrays: the same C code that runs on the target, compiled for this machine.

Arrays are float32. A dual quaternion is a row of 8, [w x y z | w' x' y' z'], a pose r + eps 1/2 t r with t in metres;
poses are defined up to sign. Arguments are checked: a wrong shape or type, an unknown name, a value that is not finite,
or a pose off unit by more than 1e-4 raises ValueError, which says which and why.
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
