"""The tasks of `companion new`, as parts of a mission's text and of its world's text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum

Sites = Mapping[str, tuple[float, float]]
"""By name, metres east and north of Home."""


class TaskName(StrEnum):
    """What a mission does."""

    PATROL = "patrol"
    DELIVERY = "delivery"
    INSPECTION = "inspection"
    RESPONSE = "response"


@dataclass(frozen=True)
class StarterTask:
    """A task in text.

    Attributes:
        question: what it does, in a line.
        story: for the head of the mission.
        sites: three places besides Home.
        sets: lines under `sets`.
        before_skills: components and events.
        skills: besides `move`.
        task: the section `task` with its comments.
        world: lines of the scenario, given the positions of the sites.
    """

    question: str
    story: tuple[str, ...]
    sites: tuple[str, str, str]
    sets: tuple[str, ...]
    before_skills: tuple[str, ...]
    skills: tuple[str, ...]
    task: tuple[str, ...]
    world: Callable[[Sites], list[str]]


_PATROL = StarterTask(
    question="three sites again and again, until the operator calls the vehicle home",
    story=("Patrol three sites for ever, until the operator calls the vehicle home.",),
    sites=("A", "B", "C"),
    sets=(),
    before_skills=(
        "# The operator's Return button, sent to the companion, is an event of the mission.",
        "events:",
        "  calledHome: {when: COMMAND.MAV_CMD_NAV_RETURN_TO_LAUNCH, latch: true}",
        "",
    ),
    skills=(),
    task=(
        "# Linear temporal logic, and patterns of it: patrolling(A, B) is G F at(A) & G F at(B),",
        "# always again at both; delayed_reaction(e, p) is G (e -> F p), after e some time p.",
        "task:",
        "  patrol: patrolling(A, B, C) | F calledHome",
        "  recall: delayed_reaction(calledHome, at(Home))",
    ),
    world=lambda sites: [
        "",
        "# A minute and a half after it was started the operator calls it home.",
        "happens:",
        "  - {at_s: 90, operator: MAV_CMD_NAV_RETURN_TO_LAUNCH}",
    ],
)
_DELIVERY = StarterTask(
    question="parcels from a depot to two customers, one at a time",
    story=("Carry a parcel from the depot to each of two customers, one at a time, and be home.",),
    sites=("Depot", "North", "East"),
    sets=("  Customer: [North, East]",),
    before_skills=(
        "# MAVLink component ids of what is on board.",
        "components: {gripper: 25}",
        "",
    ),
    skills=(
        "  take:",
        "    precondition: at(Depot) & !loaded",
        "    effect: loaded",
        "    cost: 2                         # seconds",
        "    execute: command(gripper, MAV_CMD_DO_GRIPPER, 1, 1)     # gripper 1 closes",
        "    timeout_s: 10",
        "  hand_over:",
        "    parameters: {to: Customer}",
        "    precondition: at(to) & loaded",
        "    effect: served(to) & !loaded",
        "    cost: 2",
        "    execute: command(gripper, MAV_CMD_DO_GRIPPER, 1, 0)     # it opens",
        "    timeout_s: 10",
    ),
    task=(
        "# Linear temporal logic: F is `at some time`, G `always`; F G at(Home): home, and stay.",
        "task:",
        "  serve: F served(North) & F served(East)",
        "  home: F G at(Home)",
    ),
    world=lambda sites: [
        "",
        "# The gripper does what it is asked to.",
        "payload: {component: 25, command: MAV_CMD_DO_GRIPPER, otherwise: ACCEPTED}",
    ],
)
_INSPECTION = StarterTask(
    question="a photo at each of three sites, then home",
    story=(
        "A photo at each of three sites, then home. A site where no photo can be made is left out:",
        "the camera has two tries, then it is not believed any longer that it works there.",
    ),
    sites=("A", "B", "C"),
    sets=("  Site: [A, B, C]",),
    before_skills=(
        "# MAVLink component ids of what is on board.",
        "components: {camera: 100}",
        "",
    ),
    skills=(
        "  shoot:",
        "    parameters: {site: Site}",
        "    precondition: at(site)",
        "    assumes: works(site)",
        "    effect: shot(site)",
        "    execute: photo(camera)          # done when the photo is there",
        "    tries: 2",
    ),
    task=(
        "# Linear temporal logic: F `at some time`, | `or`, ! `not`; F G at(Home): home, and stay.",
        "task:",
        "  A: F (shot(A) | !works(A))",
        "  B: F (shot(B) | !works(B))",
        "  C: F (shot(C) | !works(C))",
        "  home: F G at(Home)",
    ),
    world=lambda sites: [
        "",
        "# At B the camera fails.",
        "cameras:",
        f"  - {{component: 100, after_s: 0.6, fails: [{_about(sites['B'], 3)}]}}",
    ],
)
_RESPONSE = StarterTask(
    question="a patrol until an alarm is reported; then look there, and home",
    story=(
        "Patrol two sites until another program on board reports an alarm; then look at the gate,",
        'and be home. The program sends a datagram of JSON, {"alarm": 1}, to where --events says.',
    ),
    sites=("Gate", "A", "B"),
    sets=(),
    before_skills=(
        "events:",
        '  alarm: {when: "EVENT[alarm] > 0", latch: true}     # it stays true',
        "",
    ),
    skills=(
        "  look:",
        "    precondition: at(Gate) & alarm",
        "    effect: looked",
        "    cost: 5                         # seconds",
        "    execute: wait(5)",
    ),
    task=(
        "# Linear temporal logic: G is `always`, F `at some time`, -> `implies`.",
        "task:",
        "  patrol: patrolling(A, B) | F alarm",
        "  answer: G (alarm -> F looked)",
        "  home: G (looked -> F G at(Home))",
    ),
    world=lambda sites: [
        "",
        "# A program on board sees something after 40 s.",
        "happens:",
        "  - {at_s: 40, report: {alarm: 1}}",
    ],
)
TASKS = {
    TaskName.PATROL: _PATROL,
    TaskName.DELIVERY: _DELIVERY,
    TaskName.INSPECTION: _INSPECTION,
    TaskName.RESPONSE: _RESPONSE,
}


def _about(at: tuple[float, float], radius_m: float) -> str:
    return f"{{east_m: {at[0]:g}, north_m: {at[1]:g}, radius_m: {radius_m:g}}}"
