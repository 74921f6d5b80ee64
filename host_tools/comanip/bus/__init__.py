"""The CAN bus: frames and their decoding, transport, logs and live buses."""

from __future__ import annotations

import importlib
import warnings

_OF_LIVE = ("BusAddress", "CONNECT_S", "LISTEN_S", "LiveBus", "open_bus")


def __getattr__(name: str):
    """Forwards the names that ``comanip.bus`` contained before it became a package, to ``comanip.bus.live``. This
    function is to be removed in the next release."""
    if name not in _OF_LIVE:
        raise AttributeError(f"module 'comanip.bus' has no attribute '{name}'")
    warnings.warn(
        f"comanip.bus.{name} is now comanip.bus.live.{name}; the old name will be removed in the next release",
        DeprecationWarning,
        stacklevel=2,
    )
    return getattr(importlib.import_module("comanip.bus.live"), name)
