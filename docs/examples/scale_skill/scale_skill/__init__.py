"""Weighs a parcel on a scale: python(weigh, place) in a mission; and says where to do it from."""

from __future__ import annotations

import math

from companion.skills import Failed, Waypoint, place_test, skill, suggester

PARCELS_KG = {"Rack": 2.6, "Shelf": 1.4}
SAMPLES = 10


@skill
def weigh(run, place: str, limit_kg: float = 2.0):
    """Takes the mean of ten readings of a scale; a parcel above the limit is a failure."""
    total_kg = 0.0
    for count in range(1, SAMPLES + 1):
        total_kg += read_scale(place)
        run.progress(count / SAMPLES, f"{total_kg / count:.1f} kg")
        run.sleep(0.2)
    mean_kg = total_kg / SAMPLES
    print(f"{place}: {mean_kg:.2f} kg")  # stands in output.txt of the call's folder
    if mean_kg > limit_kg:
        raise Failed(f"{mean_kg:.1f} kg, and the limit is {limit_kg:g} kg")


@suggester
def beside(run, place, away_m: float = 1.0):
    """Proposes eight waypoints around a place, so far away from its middle."""
    for eighth in range(8):
        angle = eighth * math.pi / 4
        yield Waypoint(
            place.east_m + away_m * math.sin(angle), place.north_m + away_m * math.cos(angle)
        )


@place_test
def out_of_downwash(run, place, waypoint, away_m: float = 0.8) -> bool:
    """A vehicle right above a scale presses on it with its air."""
    return math.dist(waypoint[:2], (place.east_m, place.north_m)) >= away_m


def read_scale(place: str) -> float:
    """Stands for the real scale: a serial port, a file of an ADC, a bus. It may block."""
    return PARCELS_KG.get(place, 0.0)
