"""The commands that convert missions from and to files of other programs: import, export."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.cli.arguments import load
from companion.cli.shipped import completions, mission_file
from companion.errors import CompanionError, MissionError
from companion.geometry import GlobalOrigin

if TYPE_CHECKING:
    from companion.plans.draft import Draft
    from companion.plans.draft_places import Given

HOME = "LAT,LON[,AMSL]"


def import_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A .plan, .mission, .waypoints, .txt, .geojson, .json, .kml or .kmz file.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="MISSION", help="The YAML file to write.")
    ],
    home: Annotated[
        str | None,
        typer.Option(metavar=HOME, help="Begin the mission here, whatever FILE says."),
    ] = None,
    up_m: Annotated[
        float | None,
        typer.Option(
            help="Height in metres above home for everything in FILE without a usable height.",
            min=1.0,
        ),
    ] = None,
    payload: Annotated[
        int | None,
        typer.Option(
            metavar="ID",
            help="Id of the MAVLink component to which commands for payloads go.",
            min=1,
            max=255,
        ),
    ] = None,
    leave_out: Annotated[
        str,
        typer.Option(
            metavar="3,7",
            help="Leave out these items of FILE. `payloads`: all commands for payloads.",
        ),
    ] = "",
    name: Annotated[
        str, typer.Option(help="Name of the mission.", show_default="that of FILE")
    ] = "",
) -> None:
    """Writes a mission that does what the plan of a ground station, or a drawn map, says.

    The mission is a YAML file that you can read and edit. Waypoints become
    places. The task visits them in their order; in any order if they have none;
    or again and again if the plan repeats for ever. If a mission cannot express
    an item, the item is named and no mission is written. This command flies
    nothing.
    """
    from companion.plans.files import import_plan

    given = _given(home, up_m, payload)
    numbers = frozenset(filter(None, leave_out.replace(" ", "").split(",")))
    text, draft = import_plan(file, given, numbers, name)
    _write(output, text)
    _tell(draft)
    typer.echo(f"written    {output}")


def export(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="MISSION|RUN",
            parser=mission_file,
            autocompletion=completions,
            help="The file of a mission, the name of an example mission, or the folder of a run.",
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="FILE.plan or FILE.geojson. An existing file is overwritten.",
        ),
    ],
    home: Annotated[
        str | None,
        typer.Option(
            metavar=HOME,
            help="Position on the earth of the home of a mission in metres, and its height.",
        ),
    ] = None,
) -> None:
    """Writes places, fence, plan and flown path for QGroundControl and for mapping tools.

    A .plan is only for display: an autopilot that flies it follows waypoints, and
    knows no task.
    """
    from companion.api.drawings import mission_drawing, run_drawing
    from companion.plans.geojson_writing import geojson_text
    from companion.plans.qgc_writing import plan_text

    texts = {".plan": plan_text, ".geojson": geojson_text, ".json": geojson_text}
    if output.suffix.lower() not in texts:
        raise typer.BadParameter(f"{output.name} is neither .plan nor .geojson", param_hint="-o")
    zero = origin_of(home)
    drawing = run_drawing(source) if source.is_dir() else mission_drawing(load(source), zero)
    text = texts[output.suffix.lower()](drawing)
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CompanionError(f"cannot write {output}: {error.strerror or error}") from error
    for line in drawing.notes:
        typer.echo(f"notice     {line}")
    typer.echo(f"written    {output}")


def _given(home: str | None, up_m: float | None, payload: int | None) -> Given:
    from companion.plans.draft_places import Given

    latitude, longitude, amsl_m = _position(home)
    place = None if latitude is None or longitude is None else (latitude, longitude)
    return Given(place, amsl_m, up_m, payload)


def origin_of(home: str | None) -> GlobalOrigin | None:
    """The place in a text LAT,LON[,AMSL]; None without a text."""
    latitude_deg, longitude_deg, amsl_m = _position(home)
    if latitude_deg is None or longitude_deg is None:
        return None
    return GlobalOrigin(latitude_deg, longitude_deg, amsl_m or 0.0)


def _position(text: str | None) -> tuple[float | None, float | None, float | None]:
    """The numbers in LAT,LON[,AMSL]."""
    if text is None:
        return None, None, None
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    bounds = (90, 180, 10_000)
    is_near = all(abs(n) <= bound for n, bound in zip(numbers, bounds, strict=False))
    if len(numbers) not in (2, 3) or not is_near:
        raise typer.BadParameter(f"{text!r} is not {HOME}, in degrees", param_hint="--home")
    return numbers[0], numbers[1], numbers[2] if numbers[2:] else None


def _write(path: Path, text: str) -> None:
    """Writes a new file; an existing one, which somebody may have edited, is never overwritten."""
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise MissionError(
            f"{path} is there already", hint="remove it, or choose another"
        ) from None
    except OSError as error:
        raise CompanionError(f"cannot write {path}: {error.strerror or error}") from error


def _along(route_m: tuple[float, float] | None) -> str:
    """The length of the flight, in words; "" if the planner chooses the order."""
    if route_m is None:
        return ""
    there_m, back_m = route_m
    back = f", {back_m:.0f} m back to Home" if back_m else ""
    return f"{there_m:.0f} m along the route{back}; "


def _tell(draft: Draft) -> None:
    """Prints a summary of what was imported."""
    from companion.plans.route_plan import metres_between

    places: dict[str, dict[str, Any]] = draft.data["places"]
    points = [(place["lat_deg"], place["lon_deg"]) for place in places.values()]
    far_m = max(metres_between(points[0], point) for point in points)
    typer.echo(f"places     {' '.join(places)}")
    typer.echo(f"distances  {_along(draft.route_m)}up to {far_m:.0f} m from Home")
    for key, words in (("up_m", "above home"), ("amsl_m", "above the sea")):
        heights = [place[key] for place in places.values() if key in place]
        if heights:
            typer.echo(f"altitudes  {min(heights):g} to {max(heights):g} m {words}")
    for name, formula in draft.data["task"].items():
        typer.echo(f"task       {name}: {formula}")
    for line in draft.notes:
        typer.echo(f"notice     {line}")
