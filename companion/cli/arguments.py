"""Arguments that several commands share, and how they are interpreted."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.sortie.preflight.arming_terms import UploadPolicy
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
        help="The YAML file of a mission, or the name of an example mission.",
    ),
]

LogDir = Annotated[
    Path,
    typer.Option(
        envvar="COMPANION_LOG_DIR",
        metavar="DIR",
        help="The folder in which run folders are created.",
        show_default="$XDG_STATE_HOME/companion, else ~/.local/state/companion",
    ),
]
Instance = Annotated[
    int,
    typer.Option(
        "--instance",
        "-i",
        help="Number of the simulator: added to its ports and its system id, as in PX4.",
        min=0,
        max=253,
    ),
]
GroundPort = Annotated[
    int,
    typer.Option(
        help="UDP port of the ground station. It is the same for all instances.", min=1, max=65535
    ),
]


def _reported_to(address: str | None) -> str | None:
    """Refuses an invalid address of reports before anything begins."""
    from companion.vehicle.report_port import place_of

    if address is not None:
        place_of(address)
    return address


Events = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        callback=_reported_to,
        help="Listen at this address for events that other programs on board report: unix:PATH "
        "or udpin:HOST:PORT.",
        show_default="nowhere",
    ),
]
Timeout = Annotated[float, typer.Option(help="Wait this many seconds for a vehicle.", min=0.1)]
Laps = Annotated[
    int | None,
    typer.Option(
        help="For missions without an end: fly home and land after this many laps. In a lap, "
        "everything that the task demands again and again is done once. A plan that comes to "
        "rest has no laps.",
        min=1,
        show_default="no limit",
    ),
]
Resume = Annotated[
    bool,
    typer.Option(
        "--resume",
        help="If the autopilot holds because it no longer heard the companion, take control back "
        "and continue the flight. This also continues a flight in which the companion was killed.",
    ),
]
LimitS = Annotated[
    float | None,
    typer.Option(
        "--limit-s",
        help="Fly home and land this many seconds after arming, by the vehicle's clock.",
        min=1.0,
        show_default="no limit",
    ),
]
Contingencies = Annotated[
    bool,
    typer.Option(
        "--contingencies",
        help="Before the flight, work out what happens if something turns out otherwise. Do not "
        "fly if the charge would then not last to a safe place.",
    ),
]
WeakFailsafes = Annotated[
    bool,
    typer.Option(
        "--accept-weak-failsafes", help="Fly even if the failsafes of the autopilot are weak."
    ),
]
AutopilotFence = Annotated[
    UploadPolicy,
    typer.Option(
        "--autopilot-fence",
        help="upload: write the mission's fence into the autopilot, but refuse to fly if it has "
        "another one; keep: fly within the fence that it has; replace: overwrite that fence; "
        "none: do not look at it.",
    ),
]
RallyPoints = Annotated[
    UploadPolicy,
    typer.Option(
        "--rally-points",
        help="Rally points of the autopilot, where its Return may land besides home. upload: "
        "write the mission's safe places, but refuse to fly if it has others; keep, replace, "
        "none: as for the fence.",
    ),
]
LinkUrl = Annotated[
    str,
    typer.Option(
        envvar="COMPANION_CONNECT",
        metavar="URL",
        help="The link to the vehicle: udpin://HOST:PORT listens, udpout://HOST:PORT sends "
        "first, tcpout://HOST:PORT connects, serial://DEVICE:BAUD is a serial port.",
    ),
]
SigningKeyFile = Annotated[
    Path | None,
    typer.Option(
        "--signing-key",
        metavar="FILE",
        envvar="COMPANION_SIGNING_KEY",
        help="Sign all messages with this key, and accept only messages signed with it. "
        "`companion key make` makes a key.",
    ),
]
UnsignedVehicle = Annotated[
    bool,
    typer.Option(
        "--unsigned-vehicle",
        help="With --signing-key: the autopilot and its devices need not sign. Ground stations "
        "still have to.",
    ),
]


def log_dir(state_home: str) -> Path:
    """Where run folders are created, by the XDG base directory specification.

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
    """Signs and verifies the frames of a command while the context lasts.

    Args:
        key: the key file; None for links without signatures.
        program: the command, under whose name its time stamps are stored.
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
    """The mission in a file; first prints a summary of its contingencies, if asked for."""
    from companion.mission.loader import load_mission

    if contingencies:
        from companion.cli.contingencies import sum_up

        sum_up(path)
    return load_mission(path)
