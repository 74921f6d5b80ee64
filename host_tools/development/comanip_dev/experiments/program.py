"""Functions shared by the programs of this package: arguments, console, signals and exit status."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable

from rich.console import Console

from comanip_dev.experiments.campaign import CampaignError

FILE_COLUMNS = 120


def positive_integer(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number of at least 1")
    return int(text)


def interrupt_on_sigterm() -> None:
    """Handles SIGTERM like Ctrl-C, so that a program that is terminated also terminates its children."""

    def interrupt(signal_number: int, frame: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)


def guarded(program: str, run: Callable[[], int], after_interruption: str = "") -> int:
    """Runs the program and returns its exit status. After an interruption or an error, prints one line instead of a
    traceback."""
    interrupt_on_sigterm()
    try:
        return run()
    except KeyboardInterrupt:
        print(f"{program}: interrupted: results are incomplete and not written{after_interruption}", file=sys.stderr)
        return 130
    except (CampaignError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2


def console() -> Console:
    """Returns a console as wide as the terminal, or FILE_COLUMNS wide when the output is a file."""
    return Console() if sys.stdout.isatty() else Console(width=FILE_COLUMNS)
