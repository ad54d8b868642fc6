"""Arguments that several commands have, and what they stand for."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.preflight.arming_terms import UploadPolicy
from companion.cli.shipped import completions, mission_file

if TYPE_CHECKING:
    from companion.mavlink.signing import Signing
    from companion.mission.model import Mission

MissionFile = Annotated[
    Path,
    typer.Argument(
        metavar="MISSION",
        parser=mission_file,
        autocompletion=completions,
        help="The mission's YAML file, or the name of one that is shipped.",
    ),
]

LogDir = Annotated[
    Path,
    typer.Option(
        envvar="COMPANION_LOG_DIR",
        help="Where run folders are made.",
        show_default="$XDG_STATE_HOME/companion, else ~/.local/state/companion",
    ),
]
Instance = Annotated[
    int,
    typer.Option("--instance", "-i", help="Shifts ports and system id, as in PX4.", min=0, max=253),
]
GroundPort = Annotated[
    int, typer.Option(help="UDP port of the ground station, for all instances.", min=1, max=65535)
]


def _reported_to(address: str | None) -> str | None:
    """An address of reports, which is refused before anything begins if it is none."""
    from companion.vehicle.report_port import place_of

    if address is not None:
        place_of(address)
    return address


Events = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        callback=_reported_to,
        help="Where other programs on board report events, EVENT[name] in the mission: unix:PATH "
        "or udpin:HOST:PORT. [default: nowhere]",
    ),
]
Timeout = Annotated[float, typer.Option(help="Seconds to wait for a vehicle.", min=0.1)]
Laps = Annotated[
    int | None,
    typer.Option(
        help="Fly home and land after so many laps, for missions without an end: each meets "
        "all that the task asks for again and again. [default: none]",
        min=1,
        show_default=False,
    ),
]
Resume = Annotated[
    bool,
    typer.Option(
        "--resume",
        help="Go on by itself after a hold that the autopilot has begun because it no longer heard "
        "this program, also in a flight that this program was cut off from.",
    ),
]
LimitS = Annotated[
    float | None,
    typer.Option(
        "--limit-s",
        help="The same after so many seconds since arming, in the vehicle's time. [default: none]",
        min=1.0,
        show_default=False,
    ),
]
Contingencies = Annotated[
    bool,
    typer.Option(
        "--contingencies",
        help="First sum up what becomes of it when something turns out otherwise; do not fly "
        "where the charge would not last.",
    ),
]
WeakFailsafes = Annotated[
    bool,
    typer.Option(
        "--accept-weak-failsafes", help="Fly although the autopilot's own failsafes are weak."
    ),
]
AutopilotFence = Annotated[
    UploadPolicy,
    typer.Option(
        "--autopilot-fence",
        help="upload: the mission's fence, unless there is somebody else's; keep: fly within the "
        "one that is there; replace: put the mission's in its place; none: do not ask for it.",
    ),
]
RallyPoints = Annotated[
    UploadPolicy,
    typer.Option(
        "--rally-points",
        help="Where the autopilot's Return lands besides home. upload: the mission's safe places, "
        "unless there are somebody else's; keep, replace, none: as for the fence.",
    ),
]
LinkUrl = Annotated[
    str,
    typer.Option(
        envvar="COMPANION_CONNECT",
        help="udpin://HOST:PORT, udpout://HOST:PORT, tcpout://HOST:PORT or serial://DEVICE:BAUD.",
    ),
]
SigningKeyFile = Annotated[
    Path | None,
    typer.Option(
        "--signing-key",
        metavar="FILE",
        envvar="COMPANION_SIGNING_KEY",
        help="Sign all messages, and accept only signed ones: see `companion key --help`.",
    ),
]
UnsignedVehicle = Annotated[
    bool,
    typer.Option(
        "--unsigned-vehicle",
        help="With a key: the autopilot and its devices need not sign; ground stations must.",
    ),
]


def log_dir(state_home: str) -> Path:
    """Where run folders are made, by the XDG base directory specification.

    >>> str(log_dir("")), str(log_dir("/var/state")), str(log_dir("not/absolute"))
    ('~/.local/state/companion', '/var/state/companion', '~/.local/state/companion')
    """
    state = Path(state_home)
    return (state if state.is_absolute() else Path("~/.local/state")) / "companion"


DEFAULT_LOG_DIR = log_dir(os.environ.get("XDG_STATE_HOME", ""))


@contextmanager
def signing_of(
    key: Path | None, program: str, is_vehicle_unsigned: bool
) -> Iterator[Signing | None]:
    """What signs and verifies the frames of a command, as long as the context lasts.

    Args:
        key: the key file; None for links without signatures.
        program: the command, by which its time stamps are kept.
        is_vehicle_unsigned: whether the autopilot and its devices need not sign.
    """
    from companion.mavlink.key_file import signing_by
    from companion.mavlink.signing import of_signed_vehicle, of_unsigned_vehicle

    if key is None and is_vehicle_unsigned:
        raise typer.BadParameter("needs a --signing-key", param_hint="--unsigned-vehicle")
    may_be_unsigned = of_unsigned_vehicle if is_vehicle_unsigned else of_signed_vehicle
    with signing_by(key, program, may_be_unsigned) as signing:
        yield signing


def load(path: Path, contingencies: bool = False) -> Mission:
    """The mission of a file; first its contingencies are summed up, if that is asked for."""
    from companion.mission.loader import load_mission

    if contingencies:
        from companion.cli.contingencies import sum_up

        sum_up(path)
    return load_mission(path)
