"""The charge over time, as a strip of flight.png: what was measured, planned and required."""

from __future__ import annotations

import math
from itertools import pairwise

from matplotlib.axes import Axes

from companion.record.charge_trail import ChargeTrail

LONG_S = 600.0
"""From this duration on, time is in minutes."""
LEAST_APART = 0.06
"""Share of the time axis: a replan nearer than this to the last numbered one has no number."""
ABOVE_PERCENT = 3.0


def draw_charge(axis: Axes, trail: ChargeTrail, legend_columns: int) -> None:
    """Draws the charge of a flight that has measurements, with at most so many legend columns."""
    unit_s, unit = (60.0, "min") if trail.end_s >= LONG_S else (1.0, "s")
    for number, (begin_s, end_s) in enumerate(trail.charging):
        label = "charging" if number == 0 else None
        axis.axvspan(begin_s / unit_s, end_s / unit_s, color="gold", alpha=0.35, label=label)
    _draw_measured(axis, trail, unit_s)
    for number, plan in enumerate(trail.plans):
        times = [at.time_s / unit_s for at in plan]
        labels = ("planned at least", "required") if number == 0 else (None, None)
        planned, required = [at.percent for at in plan], [at.required_percent for at in plan]
        axis.plot(times, planned, ".--", color="tab:green", linewidth=1.2, label=labels[0])
        axis.plot(times, required, ".:", color="tab:red", linewidth=1.2, label=labels[1])
    if trail.reserve_percent is not None:
        axis.axhline(trail.reserve_percent, color="tab:red", linewidth=1.0, label="reserve")
    numbered_s = -math.inf
    for time_s, replan in trail.replans:
        axis.axvline(time_s / unit_s, color="tab:gray", linewidth=0.8)
        if time_s - numbered_s >= LEAST_APART * (trail.end_s - trail.measured[0][0]):
            numbered_s = time_s
            axis.annotate(
                f"replan {replan}",
                (time_s / unit_s, 1.0),
                xycoords=axis.get_xaxis_transform(),
                xytext=(2, -9),
                textcoords="offset points",
                fontsize="small",
                color="dimgray",
            )
    known = [percent for _, percent in trail.measured if percent is not None]
    highest = max([*known, *(at.percent for at in trail.planned)], default=100.0)
    axis.set_ylim(0.0, min(104.0, 10 * math.ceil(highest / 10) + ABOVE_PERCENT))
    axis.set_xlim(trail.measured[0][0] / unit_s, trail.end_s / unit_s)
    axis.set_xlabel(f"time [{unit}]")
    axis.set_ylabel("charge [%]")
    axis.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=legend_columns,
        fontsize="small",
        frameon=False,
    )


def _draw_measured(axis: Axes, trail: ChargeTrail, unit_s: float) -> None:
    """Draws the measured charge; a reading holds until the next one."""
    label = "measured"
    readings = [*trail.measured, (trail.end_s, trail.measured[-1][1])]
    times, percents = [], []
    for (time_s, percent), (until_s, _) in pairwise(readings):
        times += [time_s / unit_s, until_s / unit_s]
        percents += 2 * [math.nan if percent is None else float(percent)]
    axis.plot(times, percents, color="tab:blue", linewidth=2.0, label=label)
