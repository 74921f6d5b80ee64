"""The error that the tools report to the user."""

from __future__ import annotations


class ToolError(Exception):
    """An error that the user can correct. The message is one line with the thing, its value and what was expected."""
