"""Stores results in one file, so that an interrupted campaign can continue."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import comanip

from comanip_dev.following.plan import Condition, Setting

Key = tuple[str, ...]
# Modules that do not affect stored results.
NOT_MEASURING = ("__main__.py", "criteria.py", "one.py", "report.py", "results.py")


def case_key(loop: str, follower: str, condition: Condition, setting: Setting, recording: str | None, seed: int) -> Key:
    """Returns the key of a case. recording: None if the hand is at rest."""
    return ("case", loop, follower, condition.label, setting.label, recording or "at rest", f"seed {seed}")


def scene_key(setting: Setting, recording: str) -> Key:
    return ("scene", setting.label, recording)


def fingerprint(*files: Path) -> str:
    """Returns a digest of everything on which a result depends: the compiled core, these tools and the given files.
    Stored results with a different digest are not used."""
    core, here = Path(comanip.__file__).parent, Path(__file__).parent
    digest = hashlib.sha256()
    tools = [path for path in here.glob("*.py") if path.name not in NOT_MEASURING]
    for path in sorted([*core.glob("_core*.so"), *tools, *files]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass
class Results:
    path: Path
    version: str
    values: dict[Key, dict]

    @classmethod
    def open(cls, path: Path, version: str) -> Results:
        values = {}
        if path.is_file():
            for line in path.read_text().splitlines():
                try:
                    entry = json.loads(line)
                except ValueError:  # the last line of an interrupted campaign may be incomplete
                    continue
                if entry["version"] == version:
                    values[tuple(entry["key"])] = entry["value"]
        return cls(path, version, values)

    def add(self, key: Key, value: dict) -> None:
        self.values[key] = value
        with self.path.open("a") as file:
            file.write(json.dumps({"version": self.version, "key": key, "value": value}) + "\n")

    def missing(self, keys: Sequence[Key]) -> list[Key]:
        return [key for key in keys if key not in self.values]
