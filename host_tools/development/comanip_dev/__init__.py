"""Tools for developers of comanip: code generation, the build of the core, reports and experiments. The tools work
in a clone of the repository and are not installed."""

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
