"""Functions for unit quaternions [w x y z] in double precision, as arrays (..., 4) with any leading dimensions."""

from __future__ import annotations

import numpy as np


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the Hamilton product of the quaternions a and b."""
    aw, ax, ay, az = (a[..., i] for i in range(4))
    bw, bx, by, bz = (b[..., i] for i in range(4))
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def conjugate(a: np.ndarray) -> np.ndarray:
    return np.asarray(a) * np.array([1.0, -1.0, -1.0, -1.0])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the cross product, several times faster than numpy.cross()."""
    ax, ay, az = (a[..., i] for i in range(3))
    bx, by, bz = (b[..., i] for i in range(3))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def rotate(rotation: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rotates vectors (..., 3) by quaternions (..., 4)."""
    w, r = rotation[..., :1], rotation[..., 1:]
    return v + 2.0 * cross(r, cross(r, v) + w * v)


def from_vector(vector_rad: np.ndarray) -> np.ndarray:
    """Converts rotation vectors (..., 3) to quaternions (..., 4)."""
    half = 0.5 * np.asarray(vector_rad)
    angle = np.linalg.norm(half, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle), half * np.sinc(angle / np.pi)], axis=-1)


def to_vector(rotation: np.ndarray) -> np.ndarray:
    """Converts quaternions to rotation vectors (..., 3) with angles from 0 to 2 pi. A quaternion and its negative lead
    to the same orientation, but their rotation vectors turn in opposite directions."""
    sine = np.linalg.norm(rotation[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, rotation[..., :1])
    return rotation[..., 1:] * np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 0.0)


def continuous(rotation: np.ndarray) -> np.ndarray:
    """Chooses the signs of quaternions (N, 4) such that each is as close as possible to the previous one."""
    flips = np.sum(rotation[1:] * rotation[:-1], axis=1) < 0.0
    sign = np.where(np.concatenate([[False], np.cumsum(flips) % 2 == 1]), -1.0, 1.0)
    return rotation * sign[:, None]


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the angle between two rotations in rad, 0 to pi, for quaternions of either sign."""
    return 2.0 * np.arccos(np.clip(np.abs(np.sum(a * b, axis=-1)), 0.0, 1.0))
