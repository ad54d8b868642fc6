"""Log lines on standard error, for people who debug: the option `--verbose`.

Each module logs by its own name (`logging.getLogger(__name__)`), at level DEBUG; nothing is shown
unless a command is asked to. What is worth replaying is no log line but an event of events.jsonl.

A log line can neither end nor delay a flight. It is dropped if standard error is closed or full, or
if it cannot be encoded.
"""

from __future__ import annotations

import logging
import sys
from typing import Annotated

import typer

from companion.cli.terminal import write_at_once
from companion.errors import printable

FORMAT = "%(asctime)s.%(msecs)03d  %(name)s  %(message)s"
TIME_FORMAT = "%H:%M:%S"


class UnblockingHandler(logging.Handler):
    """Writes each record to standard error as one line, or not at all."""

    def emit(self, record: logging.LogRecord) -> None:
        """Writes a record if this is possible without waiting."""
        try:
            write_at_once(sys.stderr, printable(self.format(record)) + "\n")
        except Exception:  # whatever is wrong with a log line, the flight continues
            return


def show_log_lines(is_verbose: bool) -> bool:
    """Switches the log lines of our modules on or off."""
    logger = logging.getLogger("companion")
    for handler in logger.handlers[:]:
        if isinstance(handler, UnblockingHandler):
            logger.removeHandler(handler)
    logger.setLevel(logging.DEBUG if is_verbose else logging.NOTSET)
    if is_verbose:
        handler = UnblockingHandler()
        handler.setFormatter(logging.Formatter(FORMAT, TIME_FORMAT))
        logger.addHandler(handler)
    return is_verbose


Verbose = Annotated[
    bool,
    typer.Option(
        "--verbose", "-v", callback=show_log_lines, help="Write log lines to standard error."
    ),
]
"""Takes effect when the command line is parsed; the commands need not evaluate it."""
