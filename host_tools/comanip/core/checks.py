"""Checks of arguments. Each error message names the argument, its value and what was expected."""

from __future__ import annotations

import math
import numbers

import numpy as np

from comanip._core import ffi

UNIT_TOLERANCE = 1e-4


def array(name: str, value: object, shape: tuple[int | str, ...]) -> np.ndarray:
    """Returns the value as a contiguous float32 array after checking that it is finite and has this shape. A letter in
    `shape` stands for any length."""
    expected = f"float32 numpy array of shape ({', '.join(map(str, shape))}{',' * (len(shape) == 1)})"
    if not isinstance(value, np.ndarray):
        raise ValueError(f"{name}: expected a {expected}, got {type(value).__name__}")
    if value.dtype != np.float32:
        raise ValueError(f"{name}: expected a {expected}, got dtype {value.dtype}: convert with .astype(np.float32)")
    fits = len(value.shape) == len(shape) and all(isinstance(b, str) or a == b for a, b in zip(value.shape, shape))
    if not fits:
        raise ValueError(f"{name}: expected a {expected}, got shape {value.shape}")
    if not np.isfinite(value).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(value))[0])
        raise ValueError(f"{name}: not finite at index {where}: {value[where]}")
    return np.ascontiguousarray(value)


def same_length(first_name: str, first: np.ndarray, second_name: str, second: np.ndarray) -> None:
    if len(first) != len(second):
        raise ValueError(f"{second_name}: expected {len(first)} rows, as many as {first_name}, got {len(second)}")


def scalar(name: str, value: object, minimum: float = -math.inf, *, above: bool = False) -> float:
    """Returns the value as a number after checking that it is finite in float32 and not below the minimum. If `above`
    is True, it must exceed the minimum."""
    bound = "" if minimum == -math.inf else f" {'above' if above else 'of at least'} {minimum:g}"
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, np.floating)):
        raise ValueError(f"{name}: expected a number{bound}, got {type(value).__name__}")
    with np.errstate(over="ignore"):
        number = float(np.float32(value))
    if not math.isfinite(number) or number < minimum or (above and number == minimum):
        raise ValueError(f"{name}: expected a number{bound} that is finite in float32, got {float(value):g}")
    return number


def diagonal(name: str, value: object) -> list[float]:
    """Returns the diagonal of an 8 x 8 matrix. The value is one number for all components or a float32 array of 8, and
    must not be negative."""
    if not isinstance(value, np.ndarray) or value.ndim == 0:
        if not isinstance(value, (numbers.Real, np.ndarray)):
            raise ValueError(
                f"{name}: expected a number or a float32 numpy array of shape (8,), got {type(value).__name__}"
            )
        return [scalar(name, value.item() if isinstance(value, np.ndarray) else value, 0.0)] * 8
    components = array(name, value, (8,))
    if (components < 0).any():
        where = int(np.argmax(components < 0))
        raise ValueError(f"{name}: component {where} is negative: {components[where]:g}")
    return components.tolist()


def _reject_off_unit(name: str, error: np.ndarray, what: str) -> None:
    if error.size and error.max() > UNIT_TOLERANCE:
        row = int(error.argmax())
        at = f" in row {row}" if error.size > 1 else ""
        raise ValueError(f"{name}: {what}{at} is off by {error[row]:.3g}, more than {UNIT_TOLERANCE:g}")


def poses(name: str, value: object, shape: tuple[int | str, ...] = ("N", 8)) -> np.ndarray:
    """Returns the value after checking that it consists of unit dual quaternions: the primary part P and the dual part
    D must satisfy |P| = 1 and P . D = 0 within UNIT_TOLERANCE."""
    checked = array(name, value, shape)
    rows = checked.reshape(-1, 8).astype(np.float64)
    norm_error = np.abs(np.linalg.norm(rows[:, :4], axis=1) - 1.0)
    _reject_off_unit(name, norm_error, "not a unit dual quaternion: the norm of its primary part (expected 1)")
    _reject_off_unit(
        name,
        np.abs((rows[:, :4] * rows[:, 4:]).sum(axis=1)),
        "not a unit dual quaternion: the product of its primary and dual part (expected 0)",
    )
    return checked


def unit_quaternion(name: str, value: object) -> np.ndarray:
    checked = array(name, value, (4,))
    error = np.abs(np.linalg.norm(checked.astype(np.float64)) - 1.0)
    _reject_off_unit(name, error.reshape(1), "not a unit quaternion: its norm (expected 1)")
    return checked


def rotation_matrices(name: str, value: object) -> np.ndarray:
    checked = array(name, value, ("N", 3, 3))
    rows = checked.astype(np.float64)
    error = np.abs(rows @ rows.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    _reject_off_unit(name, error, "not a rotation matrix: R R^T (expected the identity)")
    if (np.linalg.det(rows) < 0).any():
        raise ValueError(f"{name}: row {int(np.argmax(np.linalg.det(rows) < 0))} is a reflection, not a rotation")
    return checked


def pointer(kind: str, values: np.ndarray):
    """Returns a C pointer to the array's memory. The array must outlive the pointer."""
    return ffi.cast(f"{kind} *", ffi.from_buffer(values)) if values.size else ffi.NULL
