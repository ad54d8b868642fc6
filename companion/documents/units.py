"""Units as people write them, and the conversion of numbers between them.

A key (`speed_mps`: metres per second) or MAVLink (`cm/s`) says which unit is wanted. A converted
number keeps as many digits as were written, but at least three.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from companion.geometry import GRAVITY_MPS2

_KNOT_MPS = 1852 / 3600
_MILE_M, _FOOT_M = 1609.344, 0.3048
_LEAST_DIGITS = 3


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit.

    Attributes:
        name: in the plural.
        quantity: what it measures; units of one quantity can be converted.
        scale: its size in the quantity's base unit.
    """

    name: str
    quantity: str
    scale: float = 1.0


_UNITS: dict[str, Unit] = {
    "m metre metres meter meters": Unit("metres", "length"),
    "mm": Unit("millimetres", "length", 1e-3),
    "cm": Unit("centimetres", "length", 1e-2),
    "dm": Unit("decimetres", "length", 0.1),
    "km": Unit("kilometres", "length", 1e3),
    "ft foot feet": Unit("feet", "length", _FOOT_M),
    "yd yard yards": Unit("yards", "length", 3 * _FOOT_M),
    "mi mile miles": Unit("miles", "length", _MILE_M),
    "nm nmi": Unit("nautical miles", "length", 1852.0),
    "m/s mps": Unit("metres per second", "speed"),
    "cm/s": Unit("centimetres per second", "speed", 1e-2),
    "km/h kmh kph": Unit("kilometres per hour", "speed", 1 / 3.6),
    "kn kt kts knot knots": Unit("knots", "speed", _KNOT_MPS),
    "mph mi/h": Unit("miles per hour", "speed", _MILE_M / 3600),
    "ft/s fps": Unit("feet per second", "speed", _FOOT_M),
    "ft/min fpm": Unit("feet per minute", "speed", _FOOT_M / 60),
    "m/s2 m/s/s mps2": Unit("metres per second squared", "acceleration"),
    "g": Unit("times gravity", "acceleration", GRAVITY_MPS2),
    "m/s3 mps3": Unit("metres per second cubed", "jerk"),
    "s sec secs second seconds": Unit("seconds", "time"),
    "us": Unit("microseconds", "time", 1e-6),
    "ms msec": Unit("milliseconds", "time", 1e-3),
    "min mins minute minutes": Unit("minutes", "time", 60.0),
    "h hr hrs hour hours": Unit("hours", "time", 3600.0),
    "deg ° degree degrees": Unit("degrees", "angle", math.pi / 180),
    "cdeg": Unit("hundredths of a degree", "angle", math.pi / 18000),
    "dege7": Unit("degrees times 10,000,000", "angle", math.pi / 180e7),
    "rad rads radian radians": Unit("radians", "angle"),
    "deg/s °/s dps": Unit("degrees per second", "rate of turn", math.pi / 180),
    "rad/s radps": Unit("radians per second", "rate of turn"),
    "hz": Unit("hertz", "frequency"),
    "khz": Unit("kilohertz", "frequency", 1e3),
    "wh": Unit("watt-hours", "energy"),
    "kwh": Unit("kilowatt-hours", "energy", 1e3),
    "kj": Unit("kilojoules", "energy", 1 / 3.6),
    "w": Unit("watts", "power"),
    "kw": Unit("kilowatts", "power", 1e3),
    "a": Unit("amperes", "current"),
    "ca": Unit("hundredths of an ampere", "current", 1e-2),
    "ma": Unit("milliamperes", "current", 1e-3),
    "v": Unit("volts", "voltage"),
    "mv": Unit("millivolts", "voltage", 1e-3),
    "% percent pct": Unit("percent", "share"),
    "d%": Unit("tenths of a percent", "share", 0.1),
    "c%": Unit("hundredths of a percent", "share", 1e-2),
    "kg": Unit("kilograms", "mass"),
}
"""What people write, and what keys end with -> the unit."""
_BY_WORD = {word: unit for words, unit in _UNITS.items() for word in words.split()}


def unit_called(word: str) -> Unit | None:
    """The unit for a spelling; None if it is unknown.

    >>> unit_called("km/h").name, unit_called("m/s²").name, unit_called("furlongs")
    ('kilometres per hour', 'metres per second squared', None)
    """
    plain = word.strip().casefold().replace("²", "2").replace("³", "3").replace("^", "")
    return _BY_WORD.get(plain)


def unit_of_key(key: str) -> Unit | None:
    """The unit with which a key ends; None if it ends with none.

    >>> unit_of_key("speed_mps").name, unit_of_key("places")
    ('metres per second', None)
    """
    _, underscore, end = key.rpartition("_")
    return unit_called(end) if underscore else None


def number_in_unit(number: str, written: str, wanted: Unit | None) -> str:
    """What to write for a number followed by a unit.

    >>> speed = unit_of_key("speed_mps")
    >>> number_in_unit("30", "km/h", speed), number_in_unit("5", "m/s", speed)
    ('write metres per second: 8.33', 'write the number alone: 5')
    >>> number_in_unit("5", "min", speed), number_in_unit("3", "times", None)
    ('write a number of metres per second', 'write the number alone: 3')

    Args:
        number: as it is written.
        written: the unit after it.
        wanted: the unit that the number must have; None if unknown.
    """
    unit = unit_called(written)
    if unit == wanted:
        return f"write the number alone: {number}"
    if wanted is None:
        return "write a number without a unit"
    if unit is None or unit.quantity != wanted.quantity:
        return f"write a number of {wanted.name}"
    converted = float(number) * unit.scale / wanted.scale
    return f"write {wanted.name}: {_with_digits(converted, number)}"


def _with_digits(value: float, written: str) -> str:
    """A number with as many digits as another one was written with, but at least three."""
    digits = max(_LEAST_DIGITS, len(re.sub(r"\D", "", written).lstrip("0")))
    return f"{float(f'{value:.{digits}g}'):.15g}"
