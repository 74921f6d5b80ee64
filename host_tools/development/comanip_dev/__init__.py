"""Tools for developers of comanip: code generation, the build of the core, reports, experiments. They run in a clone of
the repository and are not installed."""

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
