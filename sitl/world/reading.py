"""Converts the obstacles and events of a scenario file into the simulator's types.

Their models are in schema.py. Contradictions, and events that can never happen, are refused with
their place in the file.
"""

from __future__ import annotations

import json

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mavlink.framing import dialect
from sitl.world.battery_schema import check_battery_event, check_pad_event
from sitl.world.device_schema import check_camera_event, check_device_event
from sitl.world.marker_schema import check_marker_event
from sitl.world.obstacles import Obstacle
from sitl.world.scenario_events import (
    EFFECTS,
    CommandTrigger,
    ScenarioEvent,
    TimeTrigger,
    VisitTrigger,
)
from sitl.world.schema import ScenarioEventModel, ScenarioModel
from sitl.world.visits import Circle

AUTOPILOT = 1
TRIGGERS = ("at_s", "place", "command")
DEVICES = ("target", "payload", "lidar", "marker_camera", "cameras", "gimbal", "gripper")
"""Keys of devices that have a component id."""
TOLD_OF = (*DEVICES, "map", "obstacles", "pads")
"""Keys of things that events can change."""


def command_number(name: str, document: Document, *keys: str | int) -> int:
    """The number of the MAV_CMD that is named at a place of the file."""
    number = getattr(dialect, name, None)
    if not name.startswith("MAV_CMD_") or not isinstance(number, int):
        commands = [known for known in vars(dialect) if known.startswith("MAV_CMD_")]
        raise MissionError(
            f"MAVLink has no command {name}",
            document.where(*keys),
            did_you_mean(name, commands) or "write e.g. MAV_CMD_NAV_RETURN_TO_LAUNCH",
        )
    return number


def read_obstacles(
    model: ScenarioModel, document: Document, reading: DocumentReading
) -> tuple[Obstacle, ...]:
    """The obstacles; refuses equal names and obstacles without a shape."""
    read = [
        reading.read(("obstacles", i), _obstacle, model, document, i)
        for i in range(len(model.obstacles))
    ]
    return tuple(obstacle for obstacle in read if obstacle)


def _obstacle(model: ScenarioModel, document: Document, i: int) -> Obstacle:
    entry = model.obstacles[i]
    if entry.name in [other.name for other in model.obstacles[:i]]:
        raise MissionError(
            f"there are two obstacles {entry.name}", document.where("obstacles", i, "name")
        )
    if entry.circle and not entry.box:
        centre = (entry.circle.north_m, entry.circle.east_m)
        return Obstacle(entry.name, centre, centre, entry.circle.radius_m, entry.present)
    if entry.box and not entry.circle:
        (west, east), (south, north) = entry.box.east_m, entry.box.north_m
        if west >= east or south >= north:
            raise MissionError(
                f"the box of {entry.name} has no inside",
                document.where("obstacles", i, "box"),
                "[from, to] with from < to",
            )
        return Obstacle(entry.name, (south, west), (north, east), 0.0, entry.present)
    raise MissionError(
        f"the obstacle {entry.name} has no shape, or two",
        document.where("obstacles", i),
        "give it a circle or a box",
    )


def read_events(
    model: ScenarioModel, document: Document, reading: DocumentReading
) -> tuple[ScenarioEvent, ...]:
    """The events, in the order of the file."""
    if not all(map(reading.is_whole, TOLD_OF)):
        return ()
    read = [
        reading.read(("happens", i), _event, each, model, document, i)
        for i, each in enumerate(model.happens)
    ]
    return tuple(event for event in read if event)


def _event(
    entry: ScenarioEventModel, model: ScenarioModel, document: Document, i: int
) -> ScenarioEvent:
    where = document.where("happens", i)
    given = [name for name in TRIGGERS if getattr(entry, name) is not None]
    if len(given) != 1:
        raise MissionError(
            f"what happens has {len(given)} triggers instead of one",
            where,
            "one of at_s, place and command says when",
        )
    if not entry.command and (entry.nth or entry.component):
        raise MissionError("nth and component need a command", where)
    kinds = [kind for kind in EFFECTS if getattr(entry, kind) is not None]
    if not kinds:
        raise MissionError("nothing happens here", where, f"say what: {', '.join(EFFECTS)}")
    _check_effects(entry, model, document, i)
    text = "; ".join(f"{kind}: {_words(getattr(entry, kind))}" for kind in kinds)
    return ScenarioEvent(
        _trigger(entry, model, document, i),
        tuple((kind, getattr(entry, kind)) for kind in kinds),
        text,
        entry.after_s,
    )


def _trigger(
    entry: ScenarioEventModel, model: ScenarioModel, document: Document, i: int
) -> TimeTrigger | VisitTrigger | CommandTrigger:
    if entry.at_s is not None:
        return TimeTrigger(entry.at_s)
    if place := entry.place:
        return VisitTrigger(Circle((place.north_m, place.east_m), place.radius_m), place.visit)
    number = command_number(entry.command or "", document, "happens", i, "command")
    on_board = {AUTOPILOT, *(component for _, component in model.components)}
    if entry.component is not None and entry.component not in on_board:
        raise MissionError(
            f"there is no component {entry.component} on board, so this can never happen",
            document.where("happens", i, "component"),
            f"on board are {', '.join(map(str, sorted(on_board)))}",
        )
    return CommandTrigger(number, entry.nth or 1, entry.component)


def _check_effects(
    entry: ScenarioEventModel, model: ScenarioModel, document: Document, i: int
) -> None:
    for kind in ("target", "payload"):
        if getattr(entry, kind) and not getattr(model, kind):
            raise MissionError(
                f"there is no {kind} in this scenario",
                document.where("happens", i, kind),
                f"describe it with the key {kind}",
            )
    names = [obstacle.name for obstacle in model.obstacles]
    if entry.obstacle and entry.obstacle.name not in names:
        raise MissionError(
            f"there is no obstacle {entry.obstacle.name}",
            document.where("happens", i, "obstacle", "name"),
            did_you_mean(entry.obstacle.name, names) or "describe it under obstacles",
        )
    arming = entry.arming
    if arming and (arming.refused is None) == (arming.allowed is None):
        raise MissionError(
            "arming is either refused or allowed", document.where("happens", i, "arming")
        )
    if entry.operator is not None:
        command_number(entry.operator, document, "happens", i, "operator")
    if entry.answer is not None:
        command_number(entry.answer.command, document, "happens", i, "answer", "command")
    if entry.marker is not None:
        check_marker_event(entry.marker, model.marker_camera, document, i)
    if entry.camera is not None:
        check_camera_event(entry.camera, model.cameras, document, i)
    if entry.gimbal is not None:
        check_device_event("gimbal", entry.gimbal, model.gimbal, document, i)
    if entry.gripper is not None:
        check_device_event("gripper", entry.gripper, model.gripper, document, i)
    if entry.battery is not None:
        check_battery_event(entry.battery, document, i)
    if entry.pad is not None:
        check_pad_event(entry.pad, model.pads, document, i)
    if entry.gps and entry.gps.lost is None and entry.gps.noise_m is None:
        raise MissionError("gps needs lost or noise_m", document.where("happens", i, "gps"))


def _words(value: object) -> str:
    """A value as it is written in the file."""
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        return json.dumps(value)
    given = value.model_dump(exclude_unset=True)  # type: ignore[attr-defined]
    return ", ".join(f"{key} {word}" for key, word in given.items()) or "default"
