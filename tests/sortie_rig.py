"""A sortie with a FakeVehicle that stands at home, stepped by the tests."""

from __future__ import annotations

from typing import Any, Self

from fakes import FakeVehicle
from happened import Happened
from rig import Rig

from companion.acting.sortie.sortie import Sortie
from companion.acting.sortie.terms import SortieTerms
from companion.errors import Aborted
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import Phase, RunEnded, RunFailed
from companion.geometry import Ned
from companion.mission.model import Mission
from companion.mission.signals import Signal

LONGEST_S = 200.0
"""How long a phase is waited for."""


def aborted(reason: str) -> RunFailed:
    """What is told when a flight is given up."""
    return RunFailed(reason, Aborted.exit_code)


class SortieRig(Happened):
    """A sortie that nobody but its test steps.

    Args:
        asked: the mission.
        may_yield: of the sortie.
        terms: of the sortie, as `SortieTerms` has them.
    """

    def __init__(self, asked: Mission, may_yield: bool = False, **terms: Any) -> None:
        self.vehicle = FakeVehicle()
        self.rig = Rig(asked, vehicle=self.vehicle)
        self.sortie = Sortie(
            self.rig.acting,
            asked,
            terms=SortieTerms(**terms),
            may_yield=may_yield,
        )

    def step(self, *readings: tuple[Signal, float]) -> None:
        self.rig.pass_time()
        self.sortie.step(self.rig.flight.now_s, readings)

    def run(self, seconds: float) -> Self:
        end_s = self.rig.flight.now_s + seconds - 1e-6
        while self.rig.flight.now_s < end_s:
            self.step()
        return self

    def until(self, phase: Phase) -> Self:
        end_s = self.rig.flight.now_s + LONGEST_S
        while self.sortie.phase is not phase:
            assert self.rig.flight.now_s < end_s, f"not {phase} but {self.sortie.phase}"
            self.step()
        return self

    @property
    def position(self) -> Ned:
        assert self.vehicle.state is not None
        return self.vehicle.state.motion.position

    @property
    def reports(self) -> list[Stamped]:  # type: ignore[override]
        return self.rig.flight.reports

    @property
    def end(self) -> RunEnded:
        """The last event, which is the end."""
        event = self.reports[-1].event
        assert isinstance(event, RunEnded) and self.sortie.has_ended
        return event

    @property
    def failure(self) -> RunFailed:
        """The end, which is not a good one."""
        assert isinstance(self.end, RunFailed)
        return self.end
