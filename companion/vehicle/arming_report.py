"""Collects why the vehicle cannot be armed, from the autopilot's newest report of its arming
checks.

A report is a sequence of events: the summary of the arming checks, one event for each check that
has not passed, and the summary of health. A report may come in numbered chunks; the newest chunk of
each number is kept. If an event of a chunk is lost, the whole chunk is discarded.

Source: the arming check and health groups of libevents.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.mavlink.event_metadata import Arguments, EventDefinition

ERROR, WARNING = 3, 4  # log levels
MOST_CHECKS = 64
"""In a chunk; PX4 sends at most 14."""
_GROUPS = ("arming_check", "health")


class ArmingCheck(NamedTuple):
    """A check that has not passed.

    Attributes:
        level: 0 (emergency) to 4 (warning), and notices.
        modes: one bit for each group of modes that the check concerns.
    """

    level: int
    modes: int
    text: str


class ArmingReport:
    """The newest report.

    Attributes:
        is_known: whether a whole report has been heard.
    """

    def __init__(self) -> None:
        self.is_known = False
        self._chunks: dict[int, list[ArmingCheck]] = {}
        self._coming: tuple[int, list[ArmingCheck]] | None = None

    def take(self, definition: EventDefinition, level: int, text: str, given: Arguments) -> bool:
        """Takes an event; returns whether it belongs to a report."""
        if definition.group not in _GROUPS:
            return False
        coming, is_arming = self._coming, definition.group == "arming_check"
        if definition.type == "summary" and is_arming:
            self._coming = (int(given[0]), []) if given else None
        elif definition.type == "summary":
            if coming is not None and given and coming[0] == int(given[0]):
                self._chunks[coming[0]] = coming[1]
                self.is_known = True
            self._coming = None
        elif coming is not None and len(given) >= 2 and len(coming[1]) < MOST_CHECKS:
            coming[1].append(ArmingCheck(level, int(given[0]), text))
        return True

    def lose(self) -> None:
        """An event is lost for good, so the chunk being received is incomplete."""
        self._coming = None

    def reasons(self, group: int | None) -> list[str]:
        """What did not pass, worst first, without repetitions; warnings only if nothing is worse.

        Args:
            group: a group of modes; checks that concern only other groups are left out. None for
                all.
        """
        return self.errors(group) or self._told(group, WARNING)

    def errors(self, group: int | None) -> list[str]:
        """The reasons that are more than warnings."""
        return self._told(group, ERROR)

    def _told(self, group: int | None, least: int) -> list[str]:
        checks = [
            check
            for chunk in self._chunks.values()
            for check in chunk
            if check.level <= least and (group is None or check.modes >> group & 1)
        ]
        return list(dict.fromkeys(check.text for check in sorted(checks, key=lambda c: c.level)))
