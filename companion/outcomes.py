"""Outcomes of what somebody asks for: done, or refused for a reason.

A function that does what it is asked or declines returns `Refusal | None`; None says that it is
done. A refusal is expected, so it is a value and no exception.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Refusal:
    """What was asked for is not done.

    Attributes:
        reason: in words for people.

    >>> def pause(is_flying: bool) -> Refusal | None:
    ...     return None if is_flying else Refusal("nothing is flown")
    >>> if refusal := pause(is_flying=False):
    ...     print(refusal.reason)
    nothing is flown
    """

    reason: str
