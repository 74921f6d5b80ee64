"""Parameters for the unmodified control law (4) of the paper, with the error in the torso frame and no weights. The
paper does not state K and lambda. The values here are the best that ``make gain-search`` found (docs/gains.md)."""

from __future__ import annotations

_ROTATION = ("w", "x", "y", "z")


def law_parameters(
    error_frame: float,
    gain_rotation_per_s: float,
    gain_dual_per_s: float,
    weight_rotation: float,
    weight_dual: float,
    damping: float,
) -> tuple[tuple[str, float], ...]:
    """Returns the firmware's parameters for law (4). Both K and W have one value for the four components of the
    rotation and one for the four components of the dual part."""
    parameters = [("prediction", 0.0), ("error_frame", error_frame), ("damping", damping)]
    parameters += [(f"gain_{axis}_per_s", gain_rotation_per_s) for axis in _ROTATION]
    parameters += [(f"gain_dual_{axis}_per_s", gain_dual_per_s) for axis in _ROTATION]
    parameters += [(f"weight_{axis}", weight_rotation) for axis in _ROTATION]
    parameters += [(f"weight_dual_{axis}", weight_dual) for axis in _ROTATION]
    return tuple(parameters)


TORSO = 0.0

PAPER_GAINS = law_parameters(
    error_frame=TORSO,
    gain_rotation_per_s=3.0,
    gain_dual_per_s=192.0,
    weight_rotation=1.0,
    weight_dual=1.0,
    damping=3e-2,
)
