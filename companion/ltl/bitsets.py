"""Sets of small numbers as the bits of an int: bit i is set if i is in the set."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator


def indices(bits: int) -> Iterator[int]:
    """The numbers in a set, smallest first.

    >>> list(indices(0b10110))
    [1, 2, 4]
    """
    while bits:
        lowest = bits & -bits
        yield lowest.bit_length() - 1
        bits ^= lowest


def minimal(
    sets: Iterable[int], spend: Callable[[int], None] = lambda comparisons: None
) -> list[int]:
    """The sets of which no other set is a subset; smallest first.

    Args:
        spend: called with the number of comparisons that come next.

    >>> minimal([0b111, 0b001, 0b110, 0b001])
    [1, 6]
    """
    kept: list[int] = []
    with_lowest: dict[int, list[int]] = defaultdict(list)  # the kept ones, by their lowest bit
    every_lowest = 0
    for bits in sorted(sets, key=int.bit_count):
        if not bits:
            return [0]
        candidates = [with_lowest[index] for index in indices(bits & every_lowest)]
        spend(1 + len(candidates) + sum(map(len, candidates)))
        if not any(other & bits == other for group in candidates for other in group):
            kept.append(bits)
            with_lowest[(bits & -bits).bit_length() - 1].append(bits)
            every_lowest |= bits & -bits
    return kept
