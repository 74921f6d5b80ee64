"""``python -m comanip.plotting DIR`` reads summary.json and trace.csv of the run in DIR, and writes the plots to
DIR/report/*.png."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from comanip.plotting.run_data import RunDataError, read_run


def draw(folder: Path) -> list[Path]:
    """Draws all plots for which the run has data, and returns their paths. Raises RunDataError if a file is missing or
    malformed."""
    run = read_run(folder)
    try:
        from comanip.plotting import experiment, paths, style, time_plots
    except ModuleNotFoundError as error:
        raise RunDataError(f"the plots need the package {error.name}: run `make build`, or pip install it") from error
    pictures = {
        "experiment": experiment.experiment,
        "paths": paths.paths,
        "tracking": time_plots.tracking,
        "orientation": time_plots.orientation,
        "joints": time_plots.joints,
        "clearance": time_plots.clearance,
        "force": time_plots.force,
        "water": time_plots.water,
        "crank": time_plots.crank,
    }
    report = folder / "report"
    report.mkdir(exist_ok=True)
    written = []
    for name, make in pictures.items():
        path = report / f"{name}.png"
        path.unlink(missing_ok=True)  # an earlier run may have left it, and this run may have no data for it
        figure = make(run)
        if figure is not None:
            written.append(style.save(figure, path))
    return written


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="comanip.plotting", description="Draws the plots of a finished run into DIR/report/*.png."
    )
    parser.add_argument("dir", type=Path, metavar="DIR", help="the folder that the simulator wrote")
    arguments = parser.parse_args(argv)
    try:
        written = draw(arguments.dir)
    except (RunDataError, OSError) as error:
        print(f"comanip.plotting: {error}", file=sys.stderr)
        return 1
    print(f"wrote {len(written)} pictures: {arguments.dir / 'report'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
