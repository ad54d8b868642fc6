"""Events of a scenario: when they happen, what they do, and mistakes in them."""

import json
from pathlib import Path

import numpy as np
import pytest
from wire import Wire, companion_heartbeat

from companion.errors import MissionError
from companion.mavlink.framing import dialect
from companion.motion.grid import OccupancyGrid
from sitl.link.routing import LinkName
from sitl.results import MavResult
from sitl.world.scenario import Scenario, parse_scenario
from sitl.world.schema import json_schema

USER_1 = dialect.MAV_CMD_USER_1
MISSIONS = Path(__file__).parents[3] / "missions"
WORLD = """\
version: 1
map: hall.yaml
target: {component: 26}
payload: {command: MAV_CMD_USER_1, otherwise: ACCEPTED}
obstacles:
  - {name: crate, circle: {east_m: 0, north_m: 3, radius_m: 0.5}, present: false}
  - {name: shelf, box: {east_m: [4, 6], north_m: [-1, 1]}}
pads:
  - {name: Dock, east_m: 0, north_m: 0, radius_m: 1}
  - {name: Locker, east_m: 0, north_m: 9, radius_m: 1, swap_s: 5}
happens:
"""


def parse(events: str) -> Scenario:
    return parse_scenario(WORLD + events, Path("missions/a.sim.yaml"))


def fly(events: str) -> Wire:
    grid = OccupancyGrid(np.zeros((200, 200), dtype=np.bool_), 0.1, (-10.0, -10.0))
    wire = Wire(parse(events), grid)
    wire.send(companion_heartbeat())
    return wire


def test_an_event_happens_once_in_its_step() -> None:
    wire = fly("  - {at_s: 1, after_s: 0.5, target: seen}\n  - {at_s: 1, target: lost}\n")
    wire.run(1.496)
    assert wire.simulation.event_log == [(1.0, "target: lost")]
    wire.run(3.0)
    assert wire.simulation.event_log == [(1.0, "target: lost"), (1.5, "target: seen")]
    assert wire.last("NAMED_VALUE_INT").value == 1


def test_the_nth_command_to_a_component_counts_and_repetitions_do_not() -> None:
    wire = fly("  - {command: MAV_CMD_USER_1, nth: 2, component: 25, target: seen}\n")
    wire.command(USER_1, component=26)
    wire.command(USER_1, component=25)
    again = dialect.MAVLink_command_long_message(1, 25, USER_1, 1, *(0.0,) * 7)
    wire.send(again)
    wire.run(1.0)
    assert wire.simulation.event_log == []
    wire.command(USER_1, component=25)
    assert [text for _, text in wire.simulation.event_log] == ["target: seen"]


def test_an_obstacle_is_seen_while_it_is_there() -> None:
    events = "  - {at_s: 1, obstacle: {name: crate, present: true}}\n"
    wire = fly(events + "  - {at_s: 2, obstacle: {name: crate, present: false}}\n")
    ahead, right = [], []
    for _ in range(3):
        wire.run(0.99)
        ahead.append(wire.last("OBSTACLE_DISTANCE").distances[0])
        right.append(wire.last("OBSTACLE_DISTANCE").distances[18])
    assert ahead == [pytest.approx(cm, abs=11) for cm in (1000, 250, 1000)]
    assert right == [pytest.approx(400, abs=11)] * 3


def test_the_operator_speaks_to_the_companion_alone() -> None:
    wire = fly("  - {at_s: 1, operator: MAV_CMD_NAV_RETURN_TO_LAUNCH}\n")
    wire.run(2.0)
    (asked,) = [heard.message for heard in wire.named("COMMAND_LONG")]
    assert asked.command == dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
    assert (asked.target_system, asked.target_component) == (1, 191)
    assert not wire.named("COMMAND_LONG", LinkName.GCS)
    assert wire.simulation.mode != "AUTO.RTL"


def test_progress_goes_up_to_the_final_answer() -> None:
    wire = fly("  - {at_s: 0, payload: {result: FAILED, after_s: 4, progress: true}}\n")
    wire.run(0.1)
    wire.command(USER_1, component=25)
    wire.run(5.0)
    acks = [heard.message for heard in wire.named("COMMAND_ACK")]
    assert [ack.result for ack in acks] == [MavResult.IN_PROGRESS] * 4 + [MavResult.FAILED]
    assert [ack.progress for ack in acks[:4]] == [pytest.approx(p, abs=1) for p in (0, 25, 50, 75)]


def test_a_silent_payload_answers_nothing_but_lives() -> None:
    wire = fly("  - {at_s: 0, payload: {silent: true}}\n")
    wire.run(0.1)
    assert wire.command(USER_1, component=25) == []
    wire.run(3.0)
    assert wire.named("COMMAND_ACK") == []
    beats = [h.message.get_srcComponent() for h in wire.named("HEARTBEAT")]
    assert beats.count(25) == 4


def test_a_lost_answer_is_heard_when_it_is_asked_for_again() -> None:
    wire = fly("  - {at_s: 0, payload: {result: ACCEPTED, after_s: 0.5, lost: true}}\n")
    wire.run(0.1)
    wire.command(USER_1, component=25)
    wire.run(1.0)
    wire.send(dialect.MAVLink_command_long_message(1, 25, USER_1, 1, *(0.0,) * 7))
    wire.run(2.0)
    acks = [heard.message.result for heard in wire.named("COMMAND_ACK")]
    assert acks == [MavResult.IN_PROGRESS, MavResult.ACCEPTED]


def test_a_repetition_after_the_end_is_answered_the_same() -> None:
    wire = fly("  - {at_s: 0, payload: {result: FAILED, after_s: 0.5}}\n")
    wire.run(0.1)
    wire.command(USER_1, component=25)
    wire.run(1.0)
    wire.send(dialect.MAVLink_command_long_message(1, 25, USER_1, 1, *(0.0,) * 7))
    wire.run(2.0)
    results = [heard.message.result for heard in wire.named("COMMAND_ACK")]
    assert results == [MavResult.IN_PROGRESS, MavResult.FAILED, MavResult.FAILED]


@pytest.mark.parametrize("component", [25, 26, 196])
def test_what_a_component_does_not_know_is_unsupported(component: int) -> None:
    wire = fly("  - {at_s: 9, target: seen}\n")
    answers = wire.command(dialect.MAV_CMD_REQUEST_MESSAGE, 148.0, component=component)
    assert answers == [MavResult.UNSUPPORTED]


@pytest.mark.parametrize(
    ("event", "part"),
    [
        ("{at_s: 1}", "nothing happens here"),
        ("{target: seen}", "0 triggers"),
        ("{at_s: 1, command: MAV_CMD_USER_1, target: seen}", "2 triggers"),
        ("{at_s: 1, nth: 2, target: seen}", "need a command"),
        ("{at_s: 1, obstacle: {name: crat, present: true}}", "crate"),
        ("{command: MAV_CMD_USR_1, target: seen}", "MAV_CMD_USER_1"),
        ("{command: MAV_CMD_USER_1, component: 77, target: seen}", "never happen"),
        ("{at_s: 1, arming: {}}", "refused or allowed"),
        ("{at_s: 1, gps: {}}", "lost or noise_m"),
        ("{at_s: 1, winds: {east_mps: 1}}", "wind"),
        ("{at_s: 1, operator: MAV_CMD_USR_1}", "MAV_CMD_USER_1"),
        ("{at_s: 1, battery: {}}", "say charge, known, capacity, resistance"),
        ("{at_s: 1, battery: {capacity: 0}}", "capacity"),
        ("{at_s: 1, pad: {name: Dok, works: false}}", "Did you mean Dock?"),
        ("{at_s: 1, pad: {name: Dock}}", "say works or current_a"),
        ("{at_s: 1, pad: {name: Locker, current_a: 2}}", "Locker has no charger"),
        ("{at_s: 1, link: {loss: 2}}", "loss"),
        ("{at_s: 1, answer: {command: MAV_CMD_USR_1, answer: DENIED}}", "MAV_CMD_USER_1"),
        ("{at_s: 1, answer: {command: MAV_CMD_USER_1, answer: NO}}", "NO_ANSWER"),
    ],
)
def test_mistakes_are_placed_and_explained(event: str, part: str) -> None:
    with pytest.raises(MissionError) as caught:
        parse(f"  - {event}\n")
    assert str(caught.value).startswith("missions/a.sim.yaml:12:")
    assert part in str(caught.value)


def test_checked_in_schema_is_the_generated_one() -> None:
    """If this fails: python scripts/make_schema.py."""
    assert json.loads((MISSIONS / "scenario.schema.json").read_text()) == json_schema()


def test_the_example_of_the_documentation_flies() -> None:
    page = (MISSIONS.parent / "docs" / "scenario.md").read_text()
    text = page.split("```yaml\n")[1].split("```")[0]
    grid = OccupancyGrid(np.zeros((400, 400), dtype=np.bool_), 0.1, (-20.0, -20.0))
    wire = Wire(parse_scenario(text, MISSIONS / "example.sim.yaml"), grid)
    wire.run(2.1)
    event_log = [(1.0, "wind: east_mps 2.0"), (2.0, "obstacle: name crate, present True")]
    assert wire.simulation.event_log == event_log


def test_the_faults_of_the_documentation_are_read() -> None:
    page = (MISSIONS.parent / "docs" / "scenario.md").read_text()
    faults = page.split("## Faults")[1]
    text = "version: 1\n" + faults.split("```yaml\n")[1].split("```")[0]
    assert len(parse_scenario(text, MISSIONS / "example.sim.yaml").events) == 6


def test_the_payloads_of_the_documentation_are_read() -> None:
    page = (MISSIONS.parent / "docs" / "scenario.md").read_text()
    text = "version: 1\n" + page.split("## Payloads")[1].split("```yaml\n")[1].split("```")[0]
    scenario = parse_scenario(text, MISSIONS / "example.sim.yaml")
    assert len(scenario.cameras) == 1 and scenario.gimbal and scenario.gripper
    assert len(scenario.events) == 4
