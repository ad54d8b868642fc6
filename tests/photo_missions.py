"""A mission of photos, and a flight that counts what the camera has truly made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lockstep import Lockstep
from moves import MOVE

from companion.flight_events.skills import PhotoTaken, SkillCompleted, SkillFailed
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from sitl.world.camera import Camera
from sitl.world.scenario import read_scenario

SHOOT = dialect.MAV_CMD_IMAGE_START_CAPTURE
AREA = {"east_m": [-10, 10], "north_m": [-10, 10], "cell_m": 0.25}
PLACES = {"A": (0, 2), "B": (2, 2), "C": (2, 0)}
"""Metres east and north of home."""


def photo_mission(sites: str = "ABC", **changes: Any) -> dict[str, Any]:
    """A photo at each of some places; changes are those of its skill `photo`, or of the file."""
    skill = {
        "parameters": {"s": "Site"},
        "precondition": "at(s)",
        "effect": "seen(s)",
        "execute": "photo(camera)",
        **changes.pop("photo", {}),
    }
    return {
        "version": 1,
        "name": "photos",
        "limits": {"speed_mps": 3, "up_m": [0.5, 4], "fence": [[-8, -8], [8, -8], [8, 8], [-8, 8]]},
        "places": {
            "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
            **{name: _place(name) for name in sites},
        },
        "sets": {"Place": ["Home", *sites], "Site": [*sites]},
        "components": {"camera": 100},
        "skills": {
            "move": MOVE,
            "photo": skill,
        },
        "initially": ["at(Home)"],
        "task": {"photos": " & ".join(f"F seen({name})" for name in sites)},
        **changes,
    }


def _place(name: str) -> dict[str, float]:
    east_m, north_m = PLACES[name]
    return {"east_m": east_m, "north_m": north_m, "up_m": 2}


class PhotoFlight(Lockstep):
    """Flies with a camera on board.

    Args:
        mission: what to do.
        camera: of the scenario; None for no camera.
        happens: of the scenario.
        others: more cameras.
        options: of the flight.
    """

    def __init__(
        self,
        mission: dict[str, Any],
        camera: dict[str, Any] | None = None,
        happens: list[dict[str, Any]] | None = None,
        others: Sequence[dict[str, Any]] = (),
        **options: Any,
    ) -> None:
        cameras = [*([] if camera is None else [camera]), *others]
        world = {"version": 1, "map": AREA, "happens": happens or [], "cameras": cameras}
        super().__init__(load_mission(mission), read_scenario(world), **options)

    @property
    def camera(self) -> Camera:
        """The camera itself."""
        return self.simulation._world.cameras[0]

    @property
    def made(self) -> int:
        """How many photos it has truly made."""
        return self.camera.images - self.camera.spec.images

    @property
    def asked(self) -> list[Any]:
        """The photos that the companion has asked for, each as it was sent."""
        return [said.message for said in self.commands if said.message.command == SHOOT]

    @property
    def sequences(self) -> list[int]:
        """Their numbers, each once."""
        return list(dict.fromkeys(int(message.param4) for message in self.asked))

    @property
    def told(self) -> list[tuple[int, str]]:
        """The photos that were told: number and place."""
        return [(event.number, event.place) for event in self.of(PhotoTaken)]

    @property
    def done(self) -> list[str]:
        """The skills that were completed."""
        return [event.action for event in self.of(SkillCompleted)]

    @property
    def failures(self) -> list[str]:
        """Why skills have failed."""
        return [event.reason for event in self.of(SkillFailed)]
