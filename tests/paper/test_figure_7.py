"""Figure 7: the flight of Section V in three pictures, each with its plan and its trail.

(a) "The MAV loops around three sites to search a target." (b) "A target is found, and the initial
assumption is violated [...] the MAV now flies to uploading site r1." (c) "The uploading action is
unsuccessful [...] The MAV flies to r2 to upload information. After the uploading, the MAV flies
back home." Flown with the simulator's physics, in the world of the shipped mission.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from companion.api.figures import trail_of_run
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.geometry import Ned, horizontal_distance
from companion.mission.model import Mission
from companion.record.backdrop import backdrop_of
from companion.record.figure import figure_of
from companion.record.trail import Trail

SCENARIO = Path(__file__).parents[2] / "missions" / "paper_section_v.sim.yaml"

TOLD = (PlaceReached, SkillCompleted, MissionEventChanged, SkillFailed, BeliefWithdrawn)


@dataclass
class Flown:
    """The run folder of the flight, what was told, and where the vehicle was in each part."""

    folder: Path
    trail: Trail
    reports: list[Stamped]

    def plan(self, number: int) -> tuple[list[str], list[str]]:
        """Names of the actions of prefix and loop."""
        text = (self.folder / f"plan-{number}.json").read_text(encoding="utf-8")
        plan = json.loads(text)["plan"]
        prefix, loop = ([a["action"] for a in plan[part]] for part in ("prefix", "loop"))
        return prefix, loop

    def told_in(self, number: int) -> list[FlightEvent]:
        """What was done, failed or noticed between a plan and the next one."""
        events = [stamped.event for stamped in self.reports]
        made = [i for i, event in enumerate(events) if isinstance(event, PlanMade | PlanReplaced)]
        ends = [*made, len(events)]
        between = events[ends[number] : ends[number + 1]]
        return [event for event in between if isinstance(event, TOLD)]


@pytest.fixture(scope="module")
def flown(section_v_run: Path) -> Flown:
    lines = (section_v_run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    return Flown(section_v_run, trail_of_run(section_v_run), [read_line(line) for line in lines])


def entered(mission: Mission, trail: list[Ned]) -> list[str]:
    """The places whose regions a trail enters, one after the other; where it begins, too."""

    def places(position: Ned) -> set[str]:
        return {
            name
            for name, place in mission.places.items()
            if horizontal_distance(position, place.position) <= place.inner_m
        }

    first = sorted(places(trail[0]))
    return first + [name for a, b in pairwise(trail) for name in sorted(places(b) - places(a))]


def test_the_three_pictures_are_before_the_event_after_it_and_after_the_failure(
    flown: Flown,
) -> None:
    titles = [title for title, _ in flown.trail.parts]
    assert titles == ["first plan", "replan 1: target found", "replan 2: upload(r1) failed: denied"]


def test_a_line_that_needs_no_restart_flies_the_same(flown: Flown, surveillance_run: Path) -> None:
    """surveillance.yaml: the same events at the same times, but for what is said of the line."""

    def lines(folder: Path) -> list[dict[str, object]]:
        text = (folder / "events.jsonl").read_text(encoding="utf-8")
        told = (json.loads(line) for line in text.splitlines())
        return [{k: v for k, v in line.items() if k not in ("task", "restarted")} for line in told]

    assert lines(flown.folder) == lines(surveillance_run)


def test_a_the_vehicle_loops_around_three_sites_to_search_a_target(
    flown: Flown, section_v: Mission
) -> None:
    prefix, loop = flown.plan(0)
    assert prefix == ["move(Home, A)"]
    assert loop == ["move(A, B)", "move(B, C)", "move(C, A)"]
    _, trail = flown.trail.parts[0]
    assert entered(section_v, trail) == ["Home", "A", "B", "C", "A"]
    assert flown.told_in(0) == [
        PlaceReached("A", "move(Home, A)"),
        PlaceReached("B", "move(A, B)"),
        PlaceReached("C", "move(B, C)"),
        PlaceReached("A", "move(C, A)"),
        MissionEventChanged("targetFound", holds=True),
    ]


def test_b_a_target_is_found_and_the_vehicle_flies_to_r1(flown: Flown, section_v: Mission) -> None:
    prefix, _ = flown.plan(1)
    assert prefix == ["move(here, r1)", "upload(r1)", "move(r1, Home)"]
    _, trail = flown.trail.parts[1]
    assert entered(section_v, trail) == ["r1"]
    refused = [SkillFailed("upload(r1)", "denied"), BeliefWithdrawn("canUpload(r1)")]
    assert flown.told_in(1) == [PlaceReached("r1", "move(here, r1)"), *refused]


def test_c_the_upload_has_failed_and_the_vehicle_flies_to_r2_and_home(
    flown: Flown, section_v: Mission
) -> None:
    prefix, loop = flown.plan(2)
    assert prefix == ["move(r1, r2)", "upload(r2)", "move(r2, Home)"]
    assert loop == ["wait"]
    _, trail = flown.trail.parts[2]
    assert entered(section_v, trail) == ["r1", "r2", "Home"]
    assert flown.told_in(2) == [
        PlaceReached("r2", "move(r1, r2)"),
        SkillCompleted("upload(r2)"),
        PlaceReached("Home", "move(r2, Home)"),
    ]


# -- as it is drawn --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def panels(flown: Flown, section_v: Mission) -> list[Axes]:
    return figure_of(backdrop_of(section_v), flown.trail).axes


def paths(panel: Axes) -> list[np.ndarray]:
    """The lines of more than one point, as east and north, in the order in which they are drawn."""
    lines = [np.array(line.get_xydata()) for line in panel.lines]
    return [line for line in lines if len(line) > 1]


def test_it_is_drawn_in_three_pictures_one_after_the_other(panels: list[Axes]) -> None:
    assert [panel.get_title()[:3] for panel in panels] == ["(a)", "(b)", "(c)"]
    corners = [panel.get_position().x0 for panel in panels]
    assert corners == sorted(set(corners))


@pytest.mark.parametrize("number", [0, 1, 2])
def test_each_picture_shows_its_part_bold_and_what_came_before_pale(
    number: int, panels: list[Axes], flown: Flown
) -> None:
    shown = paths(panels[number])
    assert len(shown) == number + 1
    for path, (_, trail) in zip(shown, flown.trail.parts, strict=False):
        np.testing.assert_allclose(path, [(east, north) for north, east, _ in trail])
    lines = [line for line in panels[number].lines if len(np.array(line.get_xydata())) > 1]
    widths = [line.get_linewidth() for line in lines]
    greys = [np.mean(to_rgb(line.get_color())) for line in lines]
    assert all(width < widths[-1] for width in widths[:-1])
    assert all(grey > greys[-1] for grey in greys[:-1])


def test_the_darker_a_cell_the_shorter_the_distance_to_the_next_obstacle(
    panels: list[Axes], section_v: Mission
) -> None:
    """Section V: "The darker the color, the shorter the distance." """
    (image,) = panels[0].images
    grey = np.asarray(image.norm(np.asarray(image.get_array())))
    by_distance = np.lexsort((grey.ravel(), section_v.grid.distance_m.ravel()))
    assert np.all(np.diff(grey.ravel()[by_distance]) >= 0.0)
    assert np.ptp(grey) > 0.5
    assert image.get_cmap()(0.0)[:3] == (0.0, 0.0, 0.0)  # nought is black
