"""Advice for a text that is nearly a number where a number is expected."""

from __future__ import annotations

import re

from companion.documents.units import number_in_unit, unit_called, unit_of_key
from companion.errors import Keys

_HEMISPHERE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*°?\s*([NSEW])\s*")
"""Degrees with a hemisphere."""
_UNIT = re.compile(r"\s*([-+]?\d+(?:\.\d+)?)\s*([A-Za-z%°/][A-Za-z0-9/²³^]*)\s*")
"""A number followed by a unit."""
_OTHER_MINUS = re.compile(r"\s*[\u2010-\u2015\u2212](\d+(?:\.\d+)?)\s*")
"""A number after a dash or a typographic minus."""
_PERCENT = re.compile(r"\s*(\d+(?:\.\d+)?)\s*%\s*")
_COMMENT = re.compile(r"\s*([-+]?\d+(?:\.\d+)?)#.*")
"""A number followed by a comment without a space."""
_QUOTED = re.compile(r"\s*([-+]?\d+(?:\.\d+)?)\s*")
"""A number alone, which is a text because of its quotes."""
_COMMA = re.compile(r"\s*([-+]?\d+),(\d+)\s*")
"""A number with a decimal comma."""


def number_meant(text: str, keys: Keys, is_share: bool = False) -> str:
    """What to write instead of a text that is nearly a number; empty if it is none.

    >>> number_meant("2,5", ("speed_mps",)), number_meant("fast", ("speed_mps",))
    ('write a point: 2.5.', '')
    >>> number_meant("30 km/h", ("limits", "speed_mps"))
    'write metres per second: 8.33.'
    >>> number_meant("2.5", ("speed_mps",))
    'write it without quotes: 2.5.'
    >>> number_meant("50 %", ("charge",), is_share=True)
    'write a share: 0.5.'

    Args:
        text: what stands in place of the number.
        keys: the keys of the number; the last name determines the unit.
        is_share: whether the number is a share, 0 to 1.
    """
    if is_share and (percent := _PERCENT.fullmatch(text)):
        return f"write a share: {float(percent[1]) / 100:g}."
    if minus := _OTHER_MINUS.fullmatch(text):
        return f"write the minus of the keyboard: -{minus[1]}."
    if comment := _COMMENT.fullmatch(text):
        return f"write a space before #, after {comment[1]}."
    if quoted := _QUOTED.fullmatch(text):
        return f"write it without quotes: {quoted[1]}."
    if comma := _COMMA.fullmatch(text):
        return f"write a point: {comma[1]}.{comma[2]}."
    wanted = unit_of_key(next((key for key in reversed(keys) if isinstance(key, str)), ""))
    if wanted == unit_called("deg") and (degrees := _HEMISPHERE.fullmatch(text)):
        sign = "-" if degrees[2] in "SW" else ""
        return f"write the number alone: {sign}{degrees[1]}."
    if (measured := _UNIT.fullmatch(text)) is None:
        return ""
    if wanted is None and measured[2] == "%":
        wanted = unit_called("%")  # other numbers, without a unit in the key, are percentages
    return f"{number_in_unit(measured[1], measured[2], wanted)}."
