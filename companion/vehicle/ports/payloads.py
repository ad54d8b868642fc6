"""The payloads of a vehicle."""

from __future__ import annotations

from typing import Protocol

from companion.outcomes import Outcome


class Payloads(Protocol):
    """The payloads of a vehicle, which skills command."""

    def number(self, command: str) -> int | None:
        """The number of a MAV_CMD; None if there is no command of that name."""

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        """Start a MAVLink command to a component; returns a ticket for `outcome`.

        The command fails without a final answer within `timeout_s`; if that is None, the command
        protocol determines how long to wait.
        """

    def outcome(self, ticket: int) -> Outcome:
        """How far the command of a ticket has come."""

    def leave(self, ticket: int) -> None:
        """Stop sending a command for now; its answer still counts."""

    def come_back(self, ticket: int) -> None:
        """Resume a command that was left."""

    def forget(self, ticket: int) -> None:
        """Drop a command.

        While its component still works on it, no other command with its number is sent there.
        """
