"""The exception for errors that the tools report to the user."""

from __future__ import annotations


class ToolError(Exception):
    """An error that the user can correct. The message is one line that states what is wrong and what was expected."""
