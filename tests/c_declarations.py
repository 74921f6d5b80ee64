"""C headers as cffi wants them, for tests that compile sources into a library of their own."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from comanip_dev.build_core import preprocessed

GENERATED = Path(__file__).resolve().parents[1] / "build" / "generated"


def declarations(headers: Iterable[Path], *options: str) -> str:
    """What the headers declare, with these options of the preprocessor."""
    with tempfile.TemporaryDirectory() as folder:
        return preprocessed(
            "".join(f'#include "{header}"\n' for header in headers), Path(folder), f"-I{GENERATED}", "-P", *options
        )
