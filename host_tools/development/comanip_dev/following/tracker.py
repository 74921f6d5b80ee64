"""Models a tracker with a rate, a latency and noise. Computes the samples in its HandPose frames from a hand's
motion."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from comanip_dev.following import rotations
from comanip_dev.following.recorded_hand import HandMotion

TRANSPORT_S = 150e-6  # time from the queueing of a sample to the end of its frame, as on the simulated bus
# Ratio of rotation noise to position noise, as in the simulator's tracker: 0.02 degrees at 0.05 mm.
NOISE_RAD_PER_M = np.radians(0.02) / 0.05e-3
MOUNT_M = np.array([0.3, 1.5, 0.2])
MOUNT_ROTATION = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
HAND_START_M = np.array([0.3, 0.4, 0.05])
HAND_START_ROTATION = rotations.multiply(
    rotations.from_vector(np.array([0.0, np.pi / 2, 0.0])), rotations.from_vector(np.array([0.0, 0.0, np.pi]))
)


@dataclass(frozen=True)
class Tracker:
    """A tracker. announced_error_s: latency in TrackerStatus minus the true latency."""

    rate_hz: float
    latency_s: float
    noise_m: float
    announced_error_s: float = 0.0
    seed: int = 1

    @property
    def period_us(self) -> int:
        return round(1e6 / self.rate_hz)

    @property
    def announced_latency_us(self) -> int:
        """The latency in TrackerStatus, which cannot be negative."""
        return max(0, round(1e6 * (self.latency_s + self.announced_error_s)))


@dataclass(frozen=True)
class Samples:
    """The tracker's samples: measured_us (N,), received_us (N,), position_m (N, 3), rotation (N, 4) and valid (N,).
    Positions and rotations are in the tracker's frame."""

    measured_us: np.ndarray
    received_us: np.ndarray
    position_m: np.ndarray
    rotation: np.ndarray
    valid: np.ndarray


def _noise(tracker: Tracker, motion: HandMotion, count: int) -> np.ndarray:
    """Returns standard normal random numbers (count, 6), which depend on the recording and the seed but not on the
    tracker's noise level or latency."""
    name = motion.recording.name if motion.recording else "rest"
    return np.random.default_rng([tracker.seed, zlib.crc32(name.encode())]).standard_normal((count, 6))


def measure(tracker: Tracker, motion: HandMotion) -> Samples:
    count = int(motion.duration_s * tracker.rate_hz) + 1
    measured_us = np.rint(np.arange(count) * (1e6 / tracker.rate_hz)).astype(np.int64)
    displacement_m, turn = motion.displacement(measured_us * 1e-6)
    noise = _noise(tracker, motion, count)
    back = rotations.conjugate(MOUNT_ROTATION)
    position_m = rotations.rotate(back, HAND_START_M + displacement_m - MOUNT_M)
    rotation = rotations.multiply(back, rotations.multiply(turn, HAND_START_ROTATION))
    turned = rotations.from_vector(NOISE_RAD_PER_M * tracker.noise_m * noise[:, 3:])
    return Samples(
        measured_us=measured_us,
        received_us=measured_us + round(1e6 * (tracker.latency_s + TRANSPORT_S)),
        position_m=position_m + tracker.noise_m * noise[:, :3],
        rotation=rotations.multiply(rotation, turned),
        valid=motion.visible(measured_us * 1e-6),
    )
