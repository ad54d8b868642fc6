"""Times of a run as a command prints them."""

from __future__ import annotations


def minutes(time_s: float) -> str:
    """Minutes and seconds with one decimal.

    >>> minutes(59.94), minutes(59.96), minutes(6000.0)
    ('00:59.9', '01:00.0', '100:00.0')
    """
    whole_s, tenth = divmod(round(10 * time_s), 10)
    whole_min, seconds = divmod(whole_s, 60)
    return f"{whole_min:02d}:{seconds:02d}.{tenth}"
