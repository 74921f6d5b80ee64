"""What goes wrong in the tools for a reason that the user can mend."""

from __future__ import annotations


class ToolError(Exception):
    """One line that names the thing, its value and what was expected."""
