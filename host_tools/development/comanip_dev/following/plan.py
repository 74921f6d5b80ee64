"""Defines the plan of `make following`: conditions, the halves of the recordings, settings and followers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from comanip_dev.following.tracker import Tracker

# Two halves of the recordings. Recordings of one session are in the same half, so that the two halves are independent
# when a peer is tuned on one half and judged on the other.
FOLDS = (
    ("cmu_13_08_rhand", "ethz_handheld1", "kth_ho_sample_baton", "kth_ho_sample_giver", "kth_ho_sample_taker"),
    (
        "dfki_pillow_grasp",
        "kth_ho_p1s1h2_giver",
        "kth_ho_p1s1h2_taker",
        "ktk_wheelchair_glove_raw",
        "kul_pour1_com",
        "kul_pour2_com",
        "pyomeca_boxlift_box",
        "pyomeca_boxlift_hand",
    ),
)


def folds(names: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Divides these recordings into the two halves. Recordings that are not in FOLDS are assigned alternately."""
    unknown = [name for name in sorted(names) if not any(name in fold for fold in FOLDS)]
    first, second = (tuple(sorted([*set(names).intersection(FOLDS[i]), *unknown[i::2]])) for i in (0, 1))
    return first, second


# With the former law and the rotation scale 1, the arm gets stuck during these recordings.
LOCKING = ("kth_ho_sample_taker", "pyomeca_boxlift_hand")
TAKER = "kth_ho_sample_taker"
QUICK_RECORDINGS = ("kth_ho_p1s1h2_giver", "kth_ho_sample_giver", "kth_ho_sample_taker", "kul_pour2_com")


@dataclass(frozen=True)
class Condition:
    """The properties of the tracker. announced_error_ms: announced latency minus true latency."""

    rate_hz: float
    latency_ms: float
    noise_mm: float
    announced_error_ms: float = 0.0

    @property
    def label(self) -> str:
        wrong = f", announced {self.announced_error_ms:+g} ms" if self.announced_error_ms else ""
        return f"{self.rate_hz:g} Hz, {self.latency_ms:g} ms, {self.noise_mm:g} mm{wrong}"

    def tracker(self, seed: int = 1) -> Tracker:
        return Tracker(self.rate_hz, 1e-3 * self.latency_ms, 1e-3 * self.noise_mm, 1e-3 * self.announced_error_ms, seed)


FAST, MIDDLE, SLOW = Condition(250, 4, 0.05), Condition(120, 10, 0.1), Condition(90, 30, 0.5)
JUDGED = (FAST, MIDDLE, SLOW)
RATES = tuple(replace(MIDDLE, rate_hz=rate) for rate in (60, 90, 120, 250))
LATENCIES = tuple(replace(MIDDLE, latency_ms=latency) for latency in (4, 10, 20, 30, 50))
NOISES = tuple(replace(MIDDLE, noise_mm=noise) for noise in (0.05, 0.1, 0.2, 0.5, 1.0))
WRONG = tuple(replace(c, announced_error_ms=e) for c in (MIDDLE, SLOW) for e in (-10, 10))
SWEEPS = {"rate [Hz]": RATES, "latency [ms]": LATENCIES, "noise [mm]": NOISES}
CONDITIONS = tuple(dict.fromkeys((*JUDGED, Condition(60, 50, 0.5), *RATES, *LATENCIES, *NOISES, *WRONG)))


@dataclass(frozen=True)
class Setting:
    """A task, and the share of the recorded rotation that the hand performs."""

    task: str
    rotation_scale: float

    @property
    def label(self) -> str:
        return f"{self.task}, rotation {self.rotation_scale:g}"


TELEOP, TURNING = Setting("teleop", 0.3), Setting("teleop", 1.0)
MIRROR, POUR = Setting("mirror", 0.3), Setting("pour", 0.3)
SETTINGS = (TELEOP, TURNING, MIRROR, POUR)

PAPER, FORMER, DEFAULT = "paper", "former", "default"
FIRMWARE = (PAPER, FORMER, DEFAULT)
LOOP, ODE = "loop", "ODE"  # without and with physics
# Well-known programs and the tuning values that are tried for each of them.
PEERS = {
    "one-euro": ((3.0, 100.0), (10.0, 300.0), (20.0, 1000.0)),  # minimum cutoff [Hz], beta [Hz s/m]
    "ruckig": ((0.0,), (0.5,)),  # share of the target's velocity
    "qp": ((20.0,), (35.0,)),  # gain [1/s]
}


def peer_name(peer: str, values: tuple[float, ...]) -> str:
    return f"{peer} {'/'.join(f'{value:g}' for value in values)}"


def seeds(follower: str, condition: Condition) -> tuple[int, ...]:
    """Returns the seeds for the tracker's noise. If the noise is large, the largest error depends on the seed, so
    the firmware is measured with several seeds."""
    return (1, 2, 3) if condition.noise_mm >= 0.5 and follower in FIRMWARE else (1,)


PEER_NAMES = tuple(peer_name(peer, values) for peer, choices in PEERS.items() for values in choices)
