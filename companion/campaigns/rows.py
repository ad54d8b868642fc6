"""The rows of a campaign: pure functions of its seed and their number.

Each factor has its own stream of random numbers in each row, named by its path. So row 7 needs no
earlier row, a new factor in the file does not change the others, and a row is the same on any
machine and in any order.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from numpy.random import PCG64, Generator, SeedSequence

if TYPE_CHECKING:
    from companion.flights.simulated_world import Factor

Value = bool | int | float | str
SEEDS = 2**31 - 2
"""Number of seeds; each is a valid `--seed` of `companion sim`."""
SEED_STREAM = "seed"


@dataclass(frozen=True, slots=True)
class Row:
    """A flight of a campaign before it is flown.

    Attributes:
        index: its number in the campaign, from 0.
        seed: the seed of wind, sensors and links.
        values: the values of the factors, by path.
        generation: the search's generation that has chosen it; 0 for random rows.
    """

    index: int
    seed: int
    values: Mapping[str, Value] = field(default_factory=dict)
    generation: int = 0


def random_row(factors: Sequence[Factor], campaign_seed: int, index: int) -> Row:
    """A row drawn from the distributions of its factors."""
    point = [chance(campaign_seed, index, factor.path) for factor in factors]
    return row_at(factors, campaign_seed, index, point)


def row_at(
    factors: Sequence[Factor],
    campaign_seed: int,
    index: int,
    point: Sequence[float],
    generation: int = 0,
) -> Row:
    """The row at a point of the unit cube, with a coordinate for each factor."""
    values = {
        factor.path: factor.distribution.value(float(u))
        for factor, u in zip(factors, point, strict=True)
    }
    return Row(index, seed_of(campaign_seed, index), values, generation)


def seed_of(campaign_seed: int, index: int) -> int:
    """The seed of a row's flight.

    >>> seed_of(1, 0) == seed_of(1, 0) != seed_of(1, 1)
    True
    """
    return int(chance(campaign_seed, index, SEED_STREAM) * SEEDS)


def chance(campaign_seed: int, index: int, path: str) -> float:
    """The random number of a row for a factor, in [0, 1)."""
    named = (index, zlib.crc32(path.encode()))
    return float(Generator(PCG64(SeedSequence(campaign_seed, spawn_key=named))).random())
