"""Preprocesses C headers into a form that cffi can read, for tests that compile sources into their own library."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from comanip_dev.build_core import preprocessed

GENERATED = Path(__file__).resolve().parents[1] / "build" / "generated"


def declarations(headers: Iterable[Path], *options: str) -> str:
    """Preprocesses the headers with the given options and returns their declarations."""
    with tempfile.TemporaryDirectory() as folder:
        return preprocessed(
            "".join(f'#include "{header}"\n' for header in headers), Path(folder), f"-I{GENERATED}", "-P", *options
        )
