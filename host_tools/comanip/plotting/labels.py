"""Where labels go that must not lie over each other."""

from __future__ import annotations

import numpy as np


def spread(wanted: np.ndarray, gap: float, low: float, high: float) -> np.ndarray:
    """Places near the ascending `wanted` ones, at least `gap` apart, within low..high if they all fit there: (N,) -> (N,).

    The places that are least far off in the sense of squares (pool adjacent violators): neighbours that push each other
    form a block around their common middle.
    """
    count = len(wanted)
    if count > 1:
        gap = min(gap, (high - low) / (count - 1))
    offsets = gap * np.arange(count)
    blocks: list[tuple[float, int]] = []  # mean of what is wanted less the offset, members
    for value in np.asarray(wanted, float) - offsets:
        blocks.append((float(value), 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [((a * m + b * n) / (m + n), m + n)]
    free = np.concatenate([np.full(n, mean) for mean, n in blocks]) if blocks else np.empty(0)
    return np.clip(free, low, high - offsets[-1] if count else high) + offsets
