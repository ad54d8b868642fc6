"""Measures the energy that flights take, compares it with plans, and learns a factor from that.

1. Each action that flies or hovers is measured from its beginning to its end, or as far as it came:
   by voltage times current if the autopilot reports both, and by the gauge.
2. Descents to charge, take-offs, holds and waits are not measured.
3. A late flight counts like one that uses much energy: the prediction for a leg is for the planned
   time.
4. By voltage and current a minute is enough for a measurement. By the gauge it takes the whole time
   from one charge to the next. If the gauge jumps, the measurement starts again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from companion.acting.flight import Flight
from companion.acting.journal import EnergyLearnt
from companion.flight_events.energy import EnergyUsed
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import WAIT, Action
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy.ratio_estimate import AGEING_PER_S, KnownRatios
from companion.planning.step_times import waits_s
from companion.tick import TICK_S

LOOKS_S = 1.0
WINDOW_S = 60.0
"""Length of a measurement; a third of it is enough if a charge comes before."""
OF_A_WINDOW = 0.03
"""Standard deviation of the energy of a window's flight, from gusts and directions."""
OF_A_CURVE = 0.08
"""Standard deviation of a gauge between two charges: a pack has not quite the mission's curve."""
OF_THE_GAUGE = 0.0041
"""Standard deviation of a difference of two whole percents."""
MOST_IN_A_TICK = 0.04
"""The most, as a share of the battery, that a flight takes in a tick; more is a gauge's jump."""
UNITS_PER_J = UNITS_PER_WH / 3600


@dataclass
class _Leg:
    """The action under way.

    Attributes:
        predicted: units, by the mission's figures.
        ahead: the part of that still ahead, when it was last determined.
        used: units, by voltage and current; nan without a current.
        gauge: units that the gauge showed at the beginning.
    """

    action: Action
    completed: int
    predicted: float
    ahead: float
    gauge: int
    used: float = 0.0
    seconds: float = 0.0
    looked_s: float = -math.inf


@dataclass
class _Window:
    """Some legs together.

    Attributes:
        factor: what was known about the mission's figures when a stretch began.
    """

    factor: float = 1.0
    predicted: float = 0.0
    used: float = 0.0
    counted: float = 0.0
    seconds: float = 0.0

    def add(self, leg: _Leg, flown: float, counted: float) -> None:
        self.predicted += flown
        self.used += leg.used
        self.counted += counted
        self.seconds += leg.seconds


@dataclass
class EnergyMeter:
    """Measures the energy of one flight.

    Args:
        flight: the flight.
        energy: the mission's energy; learns the factor.
    """

    flight: Flight
    energy: MissionEnergy
    _leg: _Leg | None = None
    _now_s: float = -math.inf
    _gauge: int = 0
    _window: _Window = field(default_factory=_Window)
    _stretch: _Window = field(default_factory=_Window)

    def step(self) -> None:
        """Measures one tick under a plan."""
        flight, state = self.flight, self.flight.vehicle.state
        if state is None or (state.battery.percent is None and state.battery.power_w is None):
            return  # the battery was not heard yet, so nothing was taken
        before, self._gauge = self._gauge, self.energy.charge.middle()
        elapsed_s, self._now_s = flight.now_s - self._now_s, flight.now_s
        fallen = (before - self._gauge) / self.energy.model.full
        if fallen > MOST_IN_A_TICK and elapsed_s < 3 * TICK_S:
            self._leg, self._window, self._stretch = None, _Window(), _Window()
        running = flight.task.running
        leg = self._leg
        if leg is not None and leg.action is not running:
            self._end(leg)
        elif leg is not None and elapsed_s > 3 * TICK_S:
            self._leg = None  # somebody else has flown it meanwhile
        if running is not None and (running.charger or flight.progress.is_landed_by_plan):
            self._end_stretch()
        elif running is not None and self._leg is None and running is not WAIT:
            self._begin(running)
        if (leg := self._leg) is not None and elapsed_s < 3 * TICK_S:
            leg.seconds += elapsed_s
            power_w = math.nan if state.battery.power_w is None else state.battery.power_w
            leg.used += power_w * elapsed_s * UNITS_PER_J
            if flight.now_s - leg.looked_s >= LOOKS_S:
                leg.looked_s, leg.ahead = flight.now_s, self._ahead(leg.action)

    def _begin(self, action: Action) -> None:
        if not self._stretch.seconds:
            self._stretch.factor = self.energy.known.flying.mean
        predicted = action.drain / self.energy.model.factor
        completed, gauge = self.flight.task.completed, self.energy.charge.middle()
        self._leg = _Leg(action, completed, predicted, predicted, gauge)

    def _ahead(self, action: Action) -> float:
        """The part of a flight still ahead, by the mission's figures; nan if that is unknown.

        It is also unknown if the skill includes a wait, because the rest of a wait is not
        determined.
        """
        goal, state = action.destination, self.flight.vehicle.state
        if goal is None or state is None or waits_s(action.execute):
            return math.nan
        left = self.energy.left_to(goal, math.hypot(*state.motion.velocity))
        return math.nan if left is None else left / self.energy.model.factor

    def _end(self, leg: _Leg) -> None:
        """Ends a leg that was completed or cut short."""
        self._leg = None
        is_whole = self.flight.task.completed > leg.completed
        flown = leg.predicted if is_whole else leg.predicted - leg.ahead
        counted = leg.gauge - self.energy.charge.middle()
        if not flown > 0:  # false for nan, too
            return
        for window in (self._window, self._stretch):
            window.add(leg, flown, counted)
        if self._window.seconds >= WINDOW_S:
            self._learn()

    def _end_stretch(self) -> None:
        """Ends a stretch, because the vehicle lands to charge."""
        if self._window.seconds >= WINDOW_S / 3:
            self._learn()
        stretch = self._stretch
        if stretch.seconds >= WINDOW_S / 3:
            self._learn_gauge(stretch)
        if stretch.seconds > 0:
            used = stretch.counted if math.isnan(stretch.used) else stretch.used
            expected = stretch.predicted * stretch.factor
            event = EnergyUsed(
                seconds=round(stretch.seconds, 2),
                used_wh=used / UNITS_PER_WH,
                expected_wh=expected / UNITS_PER_WH,
                factor=self.energy.known.mean,
            )
            self.flight.report(event)
        self._window, self._stretch = _Window(), _Window()

    def _learn(self) -> None:
        """Uses a window as a measurement, by voltage and current."""
        window, self._window = self._window, _Window()
        if not math.isnan(window.used):
            deviation = OF_A_WINDOW * math.sqrt(WINDOW_S / window.seconds)
            ratio, known = window.used / window.predicted, self.energy.known
            self._take(replace(known, flying=known.flying.after(ratio, deviation, window.seconds)))

    def _learn_gauge(self, stretch: _Window) -> None:
        """Uses a stretch as a measurement by the gauge, whose curve distorts shorter parts."""
        known, seconds = self.energy.known, stretch.seconds
        of_gauge = OF_THE_GAUGE * self.energy.model.full
        if math.isnan(stretch.used):
            deviation = math.hypot(OF_A_CURVE, of_gauge / stretch.predicted)
            ratio = stretch.counted / stretch.predicted
            self._take(replace(known, flying=known.flying.after(ratio, deviation, seconds)))
        elif stretch.used > 0:
            deviation = math.hypot(OF_A_CURVE, of_gauge / stretch.used)
            ratio = stretch.counted / stretch.used
            gauge = known.gauge.after(ratio, deviation, seconds, AGEING_PER_S)
            self._take(replace(known, gauge=gauge))

    def _take(self, known: KnownRatios) -> None:
        self.energy.known = known
        flying, gauge = known.flying, known.gauge
        learnt = EnergyLearnt(flying.mean, flying.deviation, gauge.mean, gauge.deviation)
        self.flight.note(learnt)
