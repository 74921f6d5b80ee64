"""Plots error, delay and noise of the followers against the tracker's rate, latency and noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from comanip.plotting.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, save
from matplotlib import pyplot as plt

COLOURS = {"default": BLUE, "former": VERMILION, "paper": GREY, "one-euro": GREEN, "ruckig": ORANGE, "qp": PURPLE}
FIGURES = (
    ("rms_mm", "RMS error [mm]", "log"),
    ("delay_ms", "delay [ms]", "linear"),
    ("noise_um", "noise at rest [um]", "log"),
)


def plot(
    rows: Sequence[dict], sweeps: dict[str, Sequence[tuple[float, str]]], judged: Sequence[str], path: Path
) -> Path:
    """Draws the plots. rows: rows of the report for teleop in the loop without physics. sweeps: (value, condition)
    pairs for each varied property of the tracker. judged: conditions in the last column, which compares all
    followers."""
    found = {(row["condition"], row["follower"]): row for row in rows}
    known = {condition for condition, _ in found}
    measured = {follower: colour for follower, colour in COLOURS.items() if follower in {name for _, name in found}}
    sweeps = {name: points for name, points in sweeps.items() if known.issuperset(condition for _, condition in points)}
    figure, axes = plt.subplots(
        len(FIGURES), len(sweeps) + 1, sharey="row", figsize=(4.0 + 2.9 * len(sweeps), 7.2), squeeze=False
    )

    def values(conditions: Iterable[str], follower: str, key: str) -> list[float]:
        return [found.get((condition, follower), {}).get(key, np.nan) for condition in conditions]

    for line, (key, label, scale) in enumerate(FIGURES):
        for column, points in enumerate(sweeps.values()):
            for follower in ("paper", "former", "default"):
                heights = values((condition for _, condition in points), follower, key)
                axes[line, column].plot([x for x, _ in points], heights, "o-", ms=3, color=COLOURS[follower])
        last = axes[line, -1]
        for k, (follower, colour) in enumerate(measured.items()):
            x_positions = np.arange(len(judged)) + 0.13 * (k - 2.5)
            last.plot(x_positions, values(judged, follower, key), "o", ms=5, color=colour, label=follower)
        last.set_xticks(
            range(len(judged)), [condition.replace(", ", "\n") for condition in judged] if line == 2 else [""] * 3
        )
        last.set_xlim(-0.5, len(judged) - 0.5)
        axes[line, 0].set_yscale(scale)
        axes[line, 0].set_ylabel(label)
    for column, name in enumerate(sweeps):
        axes[0, column].set_title(f"over {name.split(' ')[0]}")
        axes[-1, column].set_xlabel(name)
    axes[0, -1].set_title("judged conditions")
    axes[0, -1].legend(loc="upper left", bbox_to_anchor=(1.005, 1.03))
    figure.tight_layout(h_pad=0.6, w_pad=0.4)
    return save(figure, path)
