"""C headers as cffi wants them, for tests that compile sources into a library of their own."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

from comanip.build_core import prototypes

STANDARD = ("stdint.h", "stdbool.h", "stddef.h", "stdio.h", "stdatomic.h")  # cffi knows their types by itself


def declarations(headers: Iterable[Path], *options: str) -> str:
    """What the headers declare, as the compiler sees them with these options."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for header in STANDARD:
            (folder / header).touch()
        umbrella = folder / "umbrella.h"
        umbrella.write_text("".join(f'#include "{header}"\n' for header in headers))
        command = ["gcc", "-E", "-P", "-nostdinc", f"-I{folder}", *options, str(umbrella)]
        return prototypes(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
