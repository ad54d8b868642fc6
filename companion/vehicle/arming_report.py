"""What stands in the way of arming, by the autopilot's newest report of its checks.

A report is a run of events: the summary of the arming checks, an event for each check that has not
passed, the summary of health. It may come in chunks, which are counted, and the newest of each
count together. A report that has lost an event in between is left out as a whole.

Source: the arming check and health groups of libevents.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.mavlink.event_metadata import Arguments, EventDefinition

ERROR, WARNING = 3, 4  # log levels
MOST_CHECKS = 64
"""Of a chunk; PX4 sends 14 at most."""
_GROUPS = ("arming_check", "health")


class ArmingCheck(NamedTuple):
    """A check that has not passed.

    Attributes:
        level: 0 (emergency) to 4 (warning), and notices.
        modes: a bit for each group of modes that it is about.
    """

    level: int
    modes: int
    text: str


class ArmingReport:
    """The newest report.

    Attributes:
        is_known: a whole one has been heard.
    """

    def __init__(self) -> None:
        self.is_known = False
        self._chunks: dict[int, list[ArmingCheck]] = {}
        self._coming: tuple[int, list[ArmingCheck]] | None = None

    def take(self, definition: EventDefinition, level: int, text: str, given: Arguments) -> bool:
        """Takes an event; whether it is one of these reports."""
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
        """An event is lost for good: the report that is coming is not whole."""
        self._coming = None

    def reasons(self, group: int | None) -> list[str]:
        """What did not pass, once each, the worst first; warnings alone if there is nothing worse.

        Args:
            group: of modes, what is about another one is left out; None for all.
        """
        return self.errors(group) or self._told(group, WARNING)

    def errors(self, group: int | None) -> list[str]:
        """Those of the reasons that are no mere warnings."""
        return self._told(group, ERROR)

    def _told(self, group: int | None, least: int) -> list[str]:
        checks = [
            check
            for chunk in self._chunks.values()
            for check in chunk
            if check.level <= least and (group is None or check.modes >> group & 1)
        ]
        return list(dict.fromkeys(check.text for check in sorted(checks, key=lambda c: c.level)))
