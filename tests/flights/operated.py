"""A flight with an operator at a ground station, in lockstep with the simulator."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from lockstep import COMPANION, Lockstep, World
from preparations import Polled

from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import RunEnded
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns

START = dialect.MAV_CMD_MISSION_START
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
ACCEPTED, NOT_NOW = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED, UNSUPPORTED = dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED


class Operated(Lockstep):
    """A flight with an operator, who knows the companion alone.

    With `is_hosted` it is also the companion's host: every run records into it.
    """

    def __init__(self, mission: Mission, world: World, is_hosted: bool = False) -> None:
        super().__init__(mission, world, has_station=True)
        self.uploads = None
        self.runs: list[list[Stamped]] = []
        if is_hosted:
            self.companion = Companion(HostedRuns(self, mission))

    def load(self, path: Path) -> Mission:
        return load_mission(path)

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Polled:
        return Polled(mission, speed_max_mps)

    def begin_run(self, mission: Mission) -> Recorder:
        self.reports = []
        self.runs.append(self.reports)
        return self

    def end_run(self, recorder: Recorder) -> None:
        assert isinstance(self.reports[-1].event, RunEnded)

    def tell(self, stamped: Stamped) -> None:
        self.reports.append(stamped)

    def ask(self, command: int, *parameters: float) -> int:
        """Sends a command to the companion; its answer, which comes in time."""
        before, asked_s = len(self.heard), self.now_s
        self.station_commands(command, *parameters, component=COMPANION)

        def answers() -> list[Any]:
            return [
                said
                for said in self.heard[before:]
                if said.message.get_type() == "COMMAND_ACK" and said.message.command == command
            ]

        self.until(lambda: bool(answers()), limit_s=1.2)
        (answer,) = answers()
        assert (answer.message.target_system, answer.message.target_component) == (255, 190)
        assert answer.time_s - asked_s < 1.2
        return int(answer.message.result)

    @property
    def told(self) -> list[str]:
        """The companion's STATUSTEXTs as a ground station puts them together."""
        texts: dict[int, str] = {}
        for at, said in enumerate(s for s in self.heard if s.message.get_type() == "STATUSTEXT"):
            key = said.message.id or -1 - at
            texts[key] = texts.get(key, "") + said.message.text
        return list(texts.values())

    @property
    def statuses(self) -> list[int]:
        """What the companion's heartbeats said, each change once."""
        beats = [s.message for s in self.heard if s.message.get_type() == "HEARTBEAT"]
        told = [beat.system_status for beat in beats]
        return [now for i, now in enumerate(told) if i == 0 or told[i - 1] != now]

    def start_by_operator(self) -> Operated:
        """The vehicle is known, and the operator starts the mission."""
        self.until(lambda: self.companion.telemetry.state is not None, 10.0)
        assert self.ask(START) == ACCEPTED
        return self


def on_the_way_to_b(flight: Operated) -> Operated:
    """In the middle of the task, at full speed."""
    flight.until_reported(PlaceReached, place="A").run(2.0)
    assert math.hypot(*flight.simulation.flight.velocity) > 1.0
    return flight
