"""Decides, while nothing is sent, whether control that was lost is back.

    control was lost because         it is back when
    nothing was heard                the mode is still OFFBOARD; any other mode has taken control
    a pilot or a failsafe took it    both keys are there (authority.py), if we wait for an operator
    the companion was away           both keys are there, and the vehicle is where it is expected

The autopilot's own hold after the loss of our stream is one key. `resumes` is the other key, given
beforehand; it does not count if the battery is critical.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.authority import RESTARTED, loss_of_link, not_handed_over
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import SortieEvent
from companion.acting.sortie.resumption import Resumption
from companion.acting.sortie.stream_loss import StreamLossWatch
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import ControlTakenBack, FlightFoundAgain, LinkBack
from companion.outcomes import Refusal
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.state import Mode, VehicleState


class Control:
    """Watches who has control of the vehicle of one flight.

    Args:
        flight: the flight.
        may_yield: whether an operator may give control back.
        resumes: whether the operator has allowed beforehand to continue after a hold by the loss of
            our stream.
        resumption: the flight that was under way when the companion was cut off; None for none.
    """

    def __init__(
        self, flight: Flight, may_yield: bool, resumes: bool, resumption: Resumption | None
    ) -> None:
        self.may_yield = may_yield or resumes
        self._flight = flight
        self._resumes = resumes
        self._resumption = resumption
        self._stream_loss = StreamLossWatch()

    def step(self, state: VehicleState) -> None:
        """Checks the vehicle, in each tick of the flight."""
        self._stream_loss.step(self._flight.now_s, state)

    def not_handed_over(self) -> Refusal | None:
        """Why the operator may not take control back now; None if the operator may."""
        flight = self._flight
        return not_handed_over(
            flight.vehicle.state,
            flight.now_s,
            is_hold_by_stream_loss=self._stream_loss.is_hold,
            limits=flight.limits,
            kept=flight.kept_fence,
        )

    def take_back(self, news: FlightEvent) -> PhaseEnd:
        """Takes control again: streams setpoints, and continues what was interrupted."""
        self._flight.vehicle.control.regain()
        self._flight.guidance.forget_setpoint()  # hold where it is, not where it was taken from us
        return PhaseEnd(SortieEvent.HANDED_BACK, news=news)

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """One tick in which nothing is sent; ends when control is back, or will not come back."""
        outcome = self._wait(state)
        if isinstance(outcome, CompanionError):
            return PhaseEnd(SortieEvent.GIVEN_UP, outcome)
        return None if outcome is None else self.take_back(outcome)

    def _wait(self, state: VehicleState) -> CompanionError | FlightEvent | None:
        """An error if control will not come back, an event if it is back, None while waiting."""
        vehicle, now_s = self._flight.vehicle, self._flight.now_s
        if silence := loss_of_link(state, now_s):
            return silence
        if vehicle.goals.has_restarted:
            return Aborted(RESTARTED)
        if not state.heartbeat.is_recent(now_s):
            return None
        heartbeat, takeover = state.heartbeat, vehicle.control.takeover
        is_ours = heartbeat.mode is Mode.OFFBOARD and takeover is None
        holder = takeover or Takeover(heartbeat.mode, heartbeat.is_failsafe)
        if state.is_standing:
            return self._has_landed(state) if is_ours else Aborted(str(holder))
        if is_ours:
            return LinkBack() if self._resumption is None else None  # its failsafe is to come
        if not self.may_yield:
            return Aborted(str(holder))
        has_both_keys = self._resumes and self._stream_loss.is_hold
        may_fly_on = not state.battery.is_critical and self._is_expected(state)
        if has_both_keys and may_fly_on and self.not_handed_over() is None:
            self._stream_loss.note_control_back()
            return ControlTakenBack()
        return None

    def _has_landed(self, state: VehicleState) -> Aborted:
        """The reason for giving up a vehicle that has landed meanwhile.

        PX4 goes back to OFFBOARD after a landing, so this mode does not give control back.
        """
        why = None if self._resumption is None else self._resumption.why_not(state)
        return why or Aborted("the vehicle has landed meanwhile; it is not armed again")

    def _is_expected(self, state: VehicleState) -> bool:
        return self._resumption is None or self._resumption.why_asked(state) is None

    def found(self, resumption: Resumption, state: VehicleState) -> FlightFoundAgain:
        """The event for a flight that is found still under way."""
        return resumption.found(state, self._resumes)
