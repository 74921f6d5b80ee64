"""Provides a lock for work that concurrent test processes must do only once. The first process does the work while the
other processes wait."""

from __future__ import annotations

import contextlib
import fcntl
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def lock(path: Path) -> Iterator[None]:
    """Acquires a lock that only one thread of one process can hold at a time. The lock is released when the holding
    process ends, even if it crashes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
