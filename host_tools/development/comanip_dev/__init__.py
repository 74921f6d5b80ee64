"""Tools for those who develop comanip: code generation, the build of the core, reports, experiments. Run in a clone of
the repository, never installed."""

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
