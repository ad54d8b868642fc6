"""The battery of the vehicle: four cells in series, their gauge, a charger, age.

What it does is in `quadrotor.xml`: an open-circuit voltage, a resistance and one RC pair. Here its
properties have names, and the gauge counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

CAPACITY_AH = 5.0
SERIES_OHM, POLARISATION_OHM = 0.016, 0.010
"""Of a pack that is new."""


@dataclass(frozen=True, slots=True)
class BatterySpec:
    """A pack as it is put in.

    Attributes:
        charge: 0 to 1, of what it can hold.
        capacity: what it can hold, as a share of a new one's.
        resistance: how many times that of a new one.
    """

    charge: float = 1.0
    capacity: float = 1.0
    resistance: float = 1.0


NEW = BatterySpec()


@dataclass(frozen=True, slots=True)
class BatteryChange:
    """What becomes of the battery; None leaves it as it is.

    Attributes:
        charge: it jumps.
        is_known: its gauge is read.
        capacity, resistance: it ages; the charge stays the same share of what it can hold.
    """

    charge: float | None = None
    is_known: bool | None = None
    capacity: float | None = None
    resistance: float | None = None


@dataclass(frozen=True, slots=True)
class BatteryStatus:
    """The battery as its gauge reports it.

    Attributes:
        consumed_mah: drawn since the start, less what was charged.
        consumed_j: its energy at the terminals, likewise.
        mean_current_a: of the last 20 s, which the battery's RC pair knows.
        remaining_s: until empty at the mean current, None while nothing drains.
        is_charging: the current flows into the battery.
    """

    consumed_mah: float
    consumed_j: float
    mean_current_a: float
    remaining_s: float | None
    is_charging: bool


class Properties(Protocol):
    """The properties of a JSBSim, by name."""

    def __getitem__(self, name: str) -> float: ...

    def __setitem__(self, name: str, value: float) -> None: ...


class Battery:
    """The battery in a running JSBSim.

    Args:
        fdm: with the airframe loaded.
        spec: the pack at the start.

    Attributes:
        capacity: as in `BatterySpec`.
    """

    def __init__(self, fdm: Properties, spec: BatterySpec) -> None:
        self._fdm = fdm
        self._is_draining = bool(fdm["battery/is-draining"])
        self._counted_mah = 0.0
        self._fdm["battery/charge"] = self._full_charge = spec.charge
        self.capacity = 1.0
        self.age(spec.capacity, spec.resistance)

    def gauge(self) -> BatteryStatus:
        """What the gauge reports now."""
        charge, current_a = self._fdm["battery/charge"], self._fdm["battery/current-a"]
        mean_current_a = self._fdm["battery/rc-current-a"]
        drains = self.is_draining and current_a > 0 and mean_current_a > 0
        return BatteryStatus(
            self._counted_mah + self._since_mah(),
            self._fdm["battery/energy-j"],
            mean_current_a,
            charge * self._capacity_as / mean_current_a if drains else None,
            current_a < 0,
        )

    def set_charge(self, charge: float) -> None:
        """The state of charge jumps, 0 to 1; nothing counts as consumed by it."""
        self._full_charge += charge - self._fdm["battery/charge"]
        self._fdm["battery/charge"] = charge

    def age(self, capacity: float | None, resistance: float | None) -> None:
        """The pack is another one from now on, as full as it was; None leaves it.

        Args:
            capacity: as a share of a new pack's.
            resistance: how many times that of a new one.
        """
        if capacity is not None:
            self._counted_mah += self._since_mah()
            self._full_charge = self._fdm["battery/charge"]
            self.capacity = capacity
            self._fdm["battery/capacity-as"] = self._capacity_as
        if resistance is not None:
            self._fdm["battery/series-ohm"] = SERIES_OHM * resistance
            self._fdm["battery/polarisation-ohm"] = POLARISATION_OHM * resistance

    @property
    def charging_a(self) -> float:
        """The current that a charger gives the vehicle, 0 without one.

        It is constant until the terminals reach 16.8 V, then falls while the voltage is constant,
        until the battery is full.
        """
        return self._fdm["battery/charging-a"]

    @charging_a.setter
    def charging_a(self, value: float) -> None:
        self._fdm["battery/charging-a"] = value

    @property
    def is_draining(self) -> bool:
        """Whether the vehicle's own current takes charge away; a charger's always gives some."""
        return self._is_draining

    @is_draining.setter
    def is_draining(self, value: bool) -> None:
        self._is_draining = value
        self._fdm["battery/is-draining"] = float(value)

    @property
    def _capacity_as(self) -> float:
        return CAPACITY_AH * 3600 * self.capacity

    def _since_mah(self) -> float:
        """Drawn since the pack has been as it is."""
        return (self._full_charge - self._fdm["battery/charge"]) * self._capacity_as / 3.6
