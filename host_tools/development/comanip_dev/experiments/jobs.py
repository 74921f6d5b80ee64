"""Defines the runs of the experiments: scenarios, recordings and seeds, with our law and with the paper's."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from comanip_dev import REPOSITORY
from comanip_dev.experiments.campaign import CampaignError, Job
from comanip_dev.experiments.paper_gains import PAPER_GAINS

SCENARIOS = ("pour", "teleop", "mirror", "handover", "crank")
RECORDINGS_FOLDER = REPOSITORY.parent / "shared" / "data" / "hand_motion"
RECORDING_SEEDS = (1, 2, 3)
LAW_SEEDS = 5


@dataclass(frozen=True)
class Recording:
    """A recorded motion that the tracked person performs. second: the motion of the second person, if recorded."""

    scenario: str
    file: str
    reason: str
    second: str | None = None


# Each recording is scaled into the arm's reach. The scenario and the summary of each run contain the scale.
RECORDINGS = (
    Recording("pour", "kul_pour1_com.csv", "a person pours: the motion of this task"),
    Recording("pour", "kul_pour2_com.csv", "the same motion along a longer path; every sample is logged twice"),
    Recording("pour", "cmu_13_08_rhand.csv", "a person unscrews a cap and drinks: turns a vessel about other axes"),
    Recording("teleop", "ethz_handheld1.csv", "an object moved in all six degrees of freedom, as in teleoperation"),
    Recording("teleop", "dfki_pillow_grasp.csv", "repeated reach and grasp"),
    Recording(
        "teleop",
        "kth_ho_sample_giver.csv",
        "both simulated people move: one as the giver of a recorded handover, the other as its taker",
        second="kth_ho_sample_taker.csv",
    ),
    Recording("handover", "kth_ho_sample_taker.csv", "a person takes a baton, here from the robot"),
    Recording("handover", "kth_ho_p1s1h2_taker.csv", "another taker, with glitches of 20 mm near the contact"),
    Recording("handover", "kth_ho_sample_taker_raw.csv", "the first handover, without the 8 % of lost samples"),
)


def seed_jobs(seeds: int, out: Path) -> list[Job]:
    return [Job(name, seed, out / name / f"seed-{seed:02d}") for name in SCENARIOS for seed in range(1, seeds + 1)]


def recording_jobs(folder: Path, out: Path) -> list[Job]:
    """Returns the runs on recordings. Raises CampaignError if a file is missing, because the campaign would be
    incomplete."""
    missing = sorted({r.file for r in RECORDINGS if not (folder / r.file).is_file()})
    missing += sorted({r.second for r in RECORDINGS if r.second and not (folder / r.second).is_file()} - set(missing))
    if missing:
        raise CampaignError(f"{folder}: lacks {', '.join(missing)}; choose a complete folder with --recordings")
    return [
        Job(
            r.scenario,
            seed,
            out / r.scenario / f"recording-{Path(r.file).stem}-seed-{seed:02d}",
            folder / r.file,
            folder / r.second if r.second else None,
        )
        for r in RECORDINGS
        for seed in RECORDING_SEEDS
    ]


def paper_law_jobs(seeds: int, out: Path) -> list[Job]:
    return [
        Job(name, seed, out / name / f"paper-law-seed-{seed:02d}", parameters=PAPER_GAINS, arguments=("--paper-law",))
        for name in SCENARIOS
        for seed in range(1, min(seeds, LAW_SEEDS) + 1)
    ]
