"""The firmware's own ways to follow: the paper's law, the former default, the default."""

from __future__ import annotations

from collections.abc import Mapping

from comanip.following.case import Follower
from comanip.following.loop import knows, run_firmware
from comanip.paper_gains import PAPER_GAINS

PREDICTION = "prediction"


def firmware(parameters: Mapping[str, float]) -> Follower:
    """The firmware with these in place of its defaults."""
    return lambda arm, task, start_rad, motion, tracker, samples: run_firmware(
        arm, task, start_rad, motion, tracker, samples, parameters
    )


def without_prediction(parameters: Mapping[str, float]) -> dict[str, float]:
    return {**parameters, **({PREDICTION: 0.0} if knows(PREDICTION) else {})}


PAPER = without_prediction(dict(PAPER_GAINS))
FORMER = without_prediction({})
