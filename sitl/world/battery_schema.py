"""The scenario file's models of the battery and the pads, and of the changes to them."""

from __future__ import annotations

from typing import Annotated, Literal

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from sitl.flight.battery import BatteryChange, BatterySpec
from sitl.world.device_schema import DiscModel
from sitl.world.pads import PadChange, PadSpec
from sitl.world.schema_fields import Strict, described
from sitl.world.visits import Circle

_CAPACITY = "capacity, as a share of that of a new one"
_RESISTANCE = "resistance of its cells, as a multiple of that of a new one"


class BatteryModel(Strict):
    """The battery at the start."""

    charge: Annotated[float, described("state of charge, 0 to 1", ge=0, le=1)] = 1.0
    drains: Annotated[
        Literal["armed", "always"], described("when it drains; PX4's simulator: while armed")
    ] = "armed"
    capacity: Annotated[float, described(_CAPACITY, ge=0.1, le=2)] = 1.0
    resistance: Annotated[float, described(_RESISTANCE, ge=0.1, le=4)] = 1.0


class BatteryEventModel(Strict):
    """A change of the battery; keys left out change nothing."""

    charge: Annotated[float | None, described("it jumps to this charge, 0 to 1", ge=0, le=1)] = None
    known: Annotated[
        bool | None, described("whether the gauge is read; false: the charge is reported as -1")
    ] = None
    capacity: Annotated[float | None, described(_CAPACITY, ge=0.1, le=2)] = None
    resistance: Annotated[float | None, described(_RESISTANCE, ge=0.1, le=4)] = None


class PadModel(DiscModel):
    """A pad that charges or exchanges the battery of a landed, disarmed vehicle on it."""

    name: Annotated[str, described("its name, for events")] = ""
    current_a: Annotated[
        float | None, described("amperes of its charger; 5 by default", gt=0, le=100)
    ] = None
    swap_s: Annotated[
        float | None,
        described(
            "instead of charging: seconds until the battery is replaced by a full one",
            ge=0,
            le=3600,
        ),
    ] = None
    works: Annotated[bool, described("whether the pad works at the start")] = True


class PadEventModel(Strict):
    """A change of a pad; keys left out change nothing."""

    name: Annotated[str, described("the name of one of the pads", min_length=1)]
    works: Annotated[bool | None, described("whether it charges, or changes batteries")] = None
    current_a: Annotated[float | None, described("amperes of its charger", gt=0, le=100)] = None


def battery(model: BatteryModel) -> BatterySpec:
    """The battery that a file describes."""
    return BatterySpec(model.charge, model.capacity, model.resistance)


def battery_change(event: BatteryEventModel) -> BatteryChange:
    """The change that an event makes to the battery."""
    return BatteryChange(event.charge, event.known, event.capacity, event.resistance)


def pads(models: tuple[PadModel, ...], document: Document) -> tuple[PadSpec, ...]:
    """The pads that a file describes.

    Raises:
        MissionError: a pad both charges and exchanges.
    """
    for i, each in enumerate(models):
        if each.swap_s is not None and each.current_a is not None:
            raise MissionError(
                "a pad either charges or changes the battery",
                document.where("pads", i, "swap_s"),
                "leave out current_a or swap_s",
            )
    return tuple(
        PadSpec(
            Circle((each.north_m, each.east_m), each.radius_m),
            5.0 if each.current_a is None else each.current_a,
            each.swap_s,
            each.name,
            each.works,
        )
        for each in models
    )


def pad_change(event: PadEventModel) -> PadChange:
    """The change that an event makes to a pad."""
    return PadChange(event.name, event.works, event.current_a)


def check_battery_event(event: BatteryEventModel, document: Document, i: int) -> None:
    """Refuses an event without an effect.

    Raises:
        MissionError: with the place in the file.
    """
    if not event.model_fields_set:
        where = document.where("happens", i, "battery")
        hint = f"say {', '.join(BatteryEventModel.model_fields)}"
        raise MissionError("nothing becomes of the battery", where, hint)


def check_pad_event(
    event: PadEventModel, models: tuple[PadModel, ...], document: Document, i: int
) -> None:
    """Refuses an event about an unknown pad, or one without an effect.

    Raises:
        MissionError: with the place in the file.
    """
    names = [each.name for each in models if each.name]
    if event.name not in names:
        where = document.where("happens", i, "pad", "name")
        hint = did_you_mean(event.name, names) if names else "give one a name under pads"
        raise MissionError(f"there is no pad {event.name}", where, hint)
    if event.model_fields_set <= {"name"}:
        where = document.where("happens", i, "pad")
        raise MissionError("nothing becomes of the pad", where, "say works or current_a")
    is_charger = all(each.swap_s is None for each in models if each.name == event.name)
    if event.current_a is not None and not is_charger:
        where = document.where("happens", i, "pad", "current_a")
        raise MissionError(f"the pad {event.name} has no charger", where, "say works: false")
