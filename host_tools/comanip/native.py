"""Loads the compiled core for the tools that need it. The other tools work on machines without a C compiler."""

from __future__ import annotations

from comanip.errors import ToolError


def load():
    """Returns ``(ffi, lib)`` of ``comanip._core``. Raises ToolError if the module is not built."""
    try:
        from comanip._core import ffi, lib
    except ImportError as error:
        raise ToolError(
            f"the compiled core is missing ({error}): run `make build` in a clone of the repository, "
            "or `pipx install ./host_tools` there on a machine with a C compiler"
        ) from error
    return ffi, lib
