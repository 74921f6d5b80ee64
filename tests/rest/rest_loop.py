"""Calls loop.c from Python: ``Loop(BUILD).run(cases, parameters)``."""

from __future__ import annotations

import functools
import hashlib
import sys
from pathlib import Path

import cffi
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from c_declarations import declarations  # noqa: E402

CASE = np.dtype(
    [
        ("start_rad", float, 4), ("hand_rotation", float, 4), ("way_m", float, 3), ("turn_rad", float, 3),
        ("move_s", float),
        ("dead_time_s", float), ("lag_s", float), ("end_s", float, 2),
    ],
    align=True,
)  # fmt: skip
OUTCOME = np.dtype(
    [
        ("verdict", np.int32), ("start", np.int32), ("mode", np.int32), ("interrupted", np.int32, 2),
        ("peak_radps", float, (2, 4)),
        ("sign_changes", np.int32, (2, 4)), ("position_rad", float, (2, 4)),
        ("velocity_radps", float, (2, 4)), ("target", float, 7),
    ],
    align=True,
)  # fmt: skip
ACCEPTED, UNSTABLE = 0, 11  # result_t
COOPERATING = 2  # control_mode_t
RESTS, MAY_SWING = 0, 1  # parameter_set_verdict_t


class Loop:
    """The compiled loop. `library`: its file. `names`, `ranges` and `defaults`: name, (minimum, maximum) and default
    value of each parameter."""

    def __init__(self, build: Path) -> None:
        self.library = (build / "rest" / "loop.so").resolve()
        self._ffi = cffi.FFI()
        self._ffi.cdef(declarations([HERE / "loop.h"], f"-I{build.resolve() / 'generated'}"))
        self._lib = self._ffi.dlopen(str(self.library))
        for name, dtype in (("rest_case_t", CASE), ("rest_outcome_t", OUTCOME)):
            assert self._ffi.sizeof(name) == dtype.itemsize, name
        rows = [self._lib.parameter_table[i] for i in range(self._lib.PARAMETER_COUNT)]
        self.names = [self._ffi.string(row.name).decode() for row in rows]
        self.ranges = [(row.minimum, row.maximum) for row in rows]
        self.defaults = [row.default_value for row in rows]

    @functools.cached_property
    def fingerprint(self) -> str:
        """Identifies the version of the firmware and of the loop, because outcomes of another version cannot be
        reused."""
        return hashlib.sha256(self.library.read_bytes()).hexdigest()[:16]

    def run(self, cases: np.ndarray, parameters: dict[str, float]) -> np.ndarray:
        """Returns the outcomes of the cases. `parameters` replaces the defaults of those parameters that it names.
        Raises KeyError for an unknown name, and ValueError if the firmware rejects a value."""
        values = self._ffi.new("parameters_t *")
        self._lib.parameters_set_defaults(values)
        for name, value in parameters.items():
            if self._lib.parameters_set(values, self._index(name), value) != ACCEPTED:
                raise ValueError(f"{name}={value:g}: out of range")
        cases = np.ascontiguousarray(cases, CASE)
        outcomes = np.zeros(len(cases), OUTCOME)
        self._lib.rest_run(
            values, self._ffi.cast("rest_case_t *", cases.ctypes.data), len(cases),
            self._ffi.cast("rest_outcome_t *", outcomes.ctypes.data),
        )  # fmt: skip
        return outcomes

    def _index(self, name: str) -> int:
        if name not in self.names:
            raise KeyError(name)
        return self.names.index(name)
