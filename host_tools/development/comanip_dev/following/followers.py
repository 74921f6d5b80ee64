"""Provides all followers by name: the firmware with the paper's control law, with the former default law (without
prediction) or with the default law, and other programs."""

from __future__ import annotations

from collections.abc import Mapping

from comanip_dev.experiments.paper_gains import PAPER_GAINS
from comanip_dev.following import plan
from comanip_dev.following.case import Follower
from comanip_dev.following.loop import knows, run_firmware
from comanip_dev.following.one_euro import filtered

PREDICTION = "prediction"


def without_prediction(parameters: Mapping[str, float]) -> dict[str, float]:
    return {**parameters, **({PREDICTION: 0.0} if knows(PREDICTION) else {})}


PARAMETERS = {
    plan.PAPER: without_prediction(dict(PAPER_GAINS)),
    plan.FORMER: without_prediction({}),
    plan.DEFAULT: {},
}


def firmware(parameters: Mapping[str, float]) -> Follower:
    """Returns a follower that runs the firmware with these parameters instead of its defaults."""
    return lambda arm, task, start_rad, motion, tracker, samples: run_firmware(
        arm, task, start_rad, motion, tracker, samples, parameters
    )


def one_euro(min_cutoff_hz: float, beta_per_m: float) -> Follower:
    former = firmware(PARAMETERS[plan.FORMER])
    return lambda arm, task, start_rad, motion, tracker, samples: former(
        arm, task, start_rad, motion, tracker, filtered(samples, min_cutoff_hz, beta_per_m)
    )


def _ruckig(velocity_share: float) -> Follower:
    from comanip_dev.following import ruckig_follower
    from comanip_dev.following.peer_loop import run_peer

    make = ruckig_follower.velocities(velocity_share)
    return lambda *scene: run_peer(make, ruckig_follower.GAIN_PER_S, *scene)


def _qp(gain_per_s: float) -> Follower:
    from comanip_dev.following import qp_follower
    from comanip_dev.following.peer_loop import run_peer

    make = qp_follower.velocities(gain_per_s)
    return lambda *scene: run_peer(make, gain_per_s, *scene)


_PEERS = {"one-euro": one_euro, "ruckig": _ruckig, "qp": _qp}


def named(name: str) -> Follower:
    """Returns the follower with this name: plan.PAPER, plan.FORMER, plan.DEFAULT or one of plan.PEER_NAMES. The
    packages for a peer are imported only when needed."""
    if name in PARAMETERS:
        return firmware(PARAMETERS[name])
    peer, values = name.split(" ")
    return _PEERS[peer](*map(float, values.split("/")))
