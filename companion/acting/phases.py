"""Which phases does a sortie have, and where does each lead? The table, as data.

phase       works towards      then      if it fails
waiting     a state on the wire          checking    (the caller's time-out)
checking    strong failsafes             arming      end
arming      ARMED              take-off  end
take-off    AIRBORNE           offboard  land
offboard    OFFBOARD           task      land
task        the executive      landing   landing, after `otherwise`
paused      the operator's continue      task or returning
returning   a flight home      landing   holding
yielded     the operator's continue      offboard    end, when somebody has landed it
holding     HOLDING            landing   landing
parting     HOLDING            end       end
landing     LANDED             end       end
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.flight_events.sortie import Phase
from companion.vehicle.port import Goal


@dataclass(frozen=True, slots=True)
class Step:
    """A phase that works towards a goal."""

    goal: Goal
    then: Phase
    if_failed: Phase


STEPS: dict[Phase, Step] = {
    Phase.ARMING: Step(Goal.ARMED, Phase.TAKE_OFF, Phase.ENDED),
    Phase.TAKE_OFF: Step(Goal.AIRBORNE, Phase.OFFBOARD, Phase.LANDING),
    Phase.OFFBOARD: Step(Goal.OFFBOARD, Phase.TASK, Phase.LANDING),
    Phase.HOLDING: Step(Goal.HOLDING, Phase.LANDING, Phase.LANDING),
    Phase.PARTING: Step(Goal.HOLDING, Phase.ENDED, Phase.ENDED),
    Phase.LANDING: Step(Goal.LANDED, Phase.ENDED, Phase.ENDED),
}

ON_THE_GROUND = (Phase.WAITING, Phase.CHECKING)
"""Phases in which the vehicle is not ours yet."""
UNDER_TASK = (Phase.TASK, Phase.PAUSED, Phase.RETURNING)
"""Phases in which the vehicle is in OFFBOARD by our setpoints, or on the ground by its plan."""
