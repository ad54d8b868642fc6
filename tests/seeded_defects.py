"""Defects that are put into the companion for a test: subtle, and each shows in few worlds.

A defect is one patch of one place, with a short mission, and a scenario in which it seldom matters.
None of the worlds makes the mission fail without the defect.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from companion.acting.behaviour_tree import builder
from companion.acting.event_detector import EventDetector
from companion.campaigns.kit import Kit
from companion.flights.simulated_world import varied_world_of
from companion.mavlink import commands
from companion.mavlink.commands import CommandSender, Parameters
from companion.mission.events import Event
from companion.mission.loader import load_mission
from companion.vehicle_profile import VehicleProfile

LIMIT_S = 90.0
FLYING = """
sets: {Place: [Home, Far]}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         assumes: "trans_ok(from, to)", effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
goal: at(Far)
"""
AROUND_A_CORNER = f"""
version: 1
name: around_a_corner
map: {{east_m: [-3, 14], north_m: [-6, 6], walls: [{{east_m: [4, 5], north_m: [-6, 2]}}]}}
limits: {{speed_mps: 8, up_m: [0.5, 4], fence: [[-2, -5], [13, -5], [13, 5], [-2, 5]]}}
places:
  Home: {{east_m: 0, north_m: 0, up_m: 1}}
  Far: {{east_m: 9, north_m: 0, up_m: 1}}
{FLYING}"""
WHILE_A_GATE_IS_OPEN = f"""
version: 1
name: while_a_gate_is_open
limits: {{speed_mps: 3, up_m: [0.5, 4], fence: [[-2, -3], [14, -3], [14, 3], [-2, 3]]}}
places:
  Home: {{east_m: 0, north_m: 0, up_m: 1}}
  Far: {{east_m: 8, north_m: 0, up_m: 1}}
events:
  shut: {{when: "EVENT[gate] > 0.8", until: "EVENT[gate] < 0.2"}}
patience_s: 14
{FLYING.replace("goal: at(Far)", "goal: at(Far) & !shut")}"""
AN_ANSWER_THAT_TAKES_TIME = """
version: 1
name: an_answer_that_takes_time
limits: {speed_mps: 3, up_m: [0.5, 4], fence: [[-2, -3], [14, -3], [14, 3], [-2, 3]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2.5}
components: {payload: 25}
skills:
  send: {parameters: {}, assumes: canSend, effect: sent,
         execute: "command(payload, MAV_CMD_USER_1)", timeout_s: 6}
initially: [at(Home)]
goal: sent
"""
WINDS = """
version: 1
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  wind.east_mps: [-9, 9]
  wind.north_mps: [-9, 9]
  wind.turbulence_mps: [0, 0.4]
  start.heading_deg: [0, 360]
  battery.charge: [0.5, 1]
"""


@dataclass(frozen=True)
class Defect:
    """A defect.

    Attributes:
        name: what is wrong.
        mission: in which it may matter, as YAML.
        scenario: what varies, as YAML.
        put_in: patches the companion.
    """

    name: str
    mission: str
    scenario: str
    put_in: Callable[[pytest.MonkeyPatch], None]

    def kit(self) -> Kit:
        """What is flown."""
        mission = load_mission(self.mission)
        return Kit.of(mission, varied_world_of(mission, self.scenario), LIMIT_S)


def _keep_the_radius_alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(VehicleProfile, "clearance_m", property(lambda vehicle: vehicle.radius_m))


def _try_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(builder, "_tried", lambda flight, child, tries: child)


def _say_it_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(commands, "RESEND_S", 60.0)


def _wait_less_for_the_answer(patch: pytest.MonkeyPatch) -> None:
    start = CommandSender.start

    def start_hastily(
        sender: CommandSender,
        now_s: float,
        target: tuple[int, int],
        command: int,
        parameters: Parameters,
        timeout_s: float | None = None,
    ) -> int:
        waited_s = None if timeout_s is None else timeout_s - 0.5
        return start(sender, now_s, target, command, parameters, waited_s)

    patch.setattr(CommandSender, "start", start_hastily)


def _forget_until(patch: pytest.MonkeyPatch) -> None:
    wants = EventDetector._wants_to_change

    def wants_to_change(detector: EventDetector, event: Event, *about: Any) -> bool:
        is_kept = detector._holds[event.name] and event.until
        return not is_kept and wants(detector, event, *about)

    patch.setattr(EventDetector, "_wants_to_change", wants_to_change)


DEFECTS = (
    Defect(
        "routes keep the vehicle's radius alone, and nothing for its deviation",
        AROUND_A_CORNER,
        WINDS,
        _keep_the_radius_alone,
    ),
    Defect(
        "a skill is tried once, whatever its mission says",
        AN_ANSWER_THAT_TAKES_TIME.replace("timeout_s: 6", "timeout_s: 6, tries: 2"),
        """
version: 1
payload: {component: 25, command: MAV_CMD_USER_1, otherwise: ACCEPTED,
          answers: [{east_m: 0, north_m: 0, radius_m: 5, result: ACCEPTED, after_s: 0.5}]}
happens: [{command: MAV_CMD_USER_1, after_s: 0.3, payload: {result: ACCEPTED}}]
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  payload.answers.0.result: {choice: [ACCEPTED, FAILED], weights: [30, 1]}
  wind.east_mps: [-5, 5]
  wind.north_mps: [-5, 5]
  start.heading_deg: [0, 360]
""",
        _try_once,
    ),
    Defect(
        "a command that is not answered is not sent again",
        AN_ANSWER_THAT_TAKES_TIME,
        """
version: 1
payload: {component: 25, command: MAV_CMD_USER_1,
          answers: [{east_m: 0, north_m: 0, radius_m: 5, result: ACCEPTED, after_s: 0}]}
happens: [{at_s: 0, link: {port: companion, loss: 0}}]
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  happens.0.link.loss: [0, 0.02]
  wind.east_mps: [-5, 5]
  wind.north_mps: [-5, 5]
  start.heading_deg: [0, 360]
""",
        _say_it_once,
    ),
    Defect(
        "half a second less is waited for the final answer",
        AN_ANSWER_THAT_TAKES_TIME,
        """
version: 1
payload: {component: 25, command: MAV_CMD_USER_1,
          answers: [{east_m: 0, north_m: 0, radius_m: 5, result: ACCEPTED, after_s: 1}]}
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  payload.answers.0.after_s: [0.2, 5.7]
  wind.east_mps: [-5, 5]
  wind.north_mps: [-5, 5]
  start.heading_deg: [0, 360]
""",
        _wait_less_for_the_answer,
    ),
    Defect(
        "the condition that ends an event is never looked at",
        WHILE_A_GATE_IS_OPEN,
        """
version: 1
happens:
  - {at_s: 1, report: {gate: 0}}
  - {at_s: 16, report: {gate: 0}}
wind: {east_mps: 0, north_mps: 0, turbulence_mps: 0}
vary:
  happens.0.report.gate: [0, 1]
  happens.0.at_s: [5, 15]
  wind.east_mps: [-5, 5]
  start.heading_deg: [0, 360]
""",
        _forget_until,
    ),
)
