"""``write_input.py OUT TICKS LOG...``: writes to OUT the recorded runs, TICKS ticks of random frames, and TICKS / 2
ticks of a run with an operator (operated.py)."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import operated  # noqa: E402
import stimulus  # noqa: E402


def main() -> None:
    out, ticks, *paths = sys.argv[1:]
    with open(out, "wb") as file:
        for path in paths:
            file.writelines(stimulus.recorded(Path(path)))
        file.writelines(stimulus.vectors(int(ticks), seed=1))
        file.writelines(operated.operated(int(ticks) // 2, seed=3))


if __name__ == "__main__":
    main()
