"""The charge that a plan expects at the coming positions, for people who watch a flight.

Percents are of the charge, as a gauge shows it, with the lowest level that is possible.
"""

from __future__ import annotations

from companion.flight_events.charge import ChargePlanned, PlannedCharge
from companion.mission.facts import Fact
from companion.planning.energy_check import level_after, required_levels
from companion.planning.lasso import Energy, Lasso

_DIGITS = 1


def charge_ahead(
    energy: Energy, reserve: int, facts: frozenset[Fact], lasso: Lasso
) -> ChargePlanned:
    """The charge that a plan expects, to the end of its prefix and, unless it rests, of one lap.

    Args:
        energy: the energy of the problem, with the present level.
        reserve: units kept for what nobody foresees.
        facts: the facts at the beginning of the plan.
        lasso: the plan.
    """

    def percent(level: int) -> float:
        return round(energy.percents[min(max(0, level), len(energy.percents) - 1)], _DIGITS)

    required = required_levels(energy, facts, lasso)
    flown = lasso.prefix if lasso.ends_at_rest else (*lasso.prefix, *lasso.loop)
    after = (*required[1:], required[len(lasso.prefix)])
    level, ahead = energy.level, []
    for action, needed in zip(flown, after, strict=False):  # rest needs nothing more
        level = level_after(energy, level, action)
        planned = PlannedCharge(
            action=action.name,
            duration_s=action.cost_ms / 1000,
            percent=percent(level),
            required_percent=percent(needed),
        )
        ahead.append(planned)
    return ChargePlanned(
        percent=percent(energy.level),
        required_percent=percent(required[0]),
        reserve_percent=percent(reserve),
        ahead=tuple(ahead),
    )
