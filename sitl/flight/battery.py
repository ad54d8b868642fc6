"""The battery of the vehicle: four cells in series, their gauge, a charger, age.

The electrical model is in `quadrotor.xml`: an open-circuit voltage, a resistance and one RC pair.
This module gives its properties names and integrates what the gauge counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

CAPACITY_AH = 5.0
SERIES_OHM, POLARISATION_OHM = 0.016, 0.010
"""Resistances of a new pack."""


@dataclass(frozen=True, slots=True)
class BatterySpec:
    """A pack at the start.

    Attributes:
        charge: 0 to 1, as a share of what it can hold.
        capacity: what it can hold, as a share of a new pack's.
        resistance: as a multiple of a new pack's.
    """

    charge: float = 1.0
    capacity: float = 1.0
    resistance: float = 1.0


NEW = BatterySpec()


@dataclass(frozen=True, slots=True)
class BatteryChange:
    """A change of the battery; None leaves a property as it is.

    Attributes:
        charge: the new charge.
        is_known: whether its gauge can be read.
        capacity, resistance: it ages; its charge stays the same share of what it can hold.
    """

    charge: float | None = None
    is_known: bool | None = None
    capacity: float | None = None
    resistance: float | None = None


@dataclass(frozen=True, slots=True)
class BatteryStatus:
    """The battery as its gauge reports it.

    Attributes:
        consumed_mah: charge drawn since the start, minus what was charged.
        consumed_j: energy at the terminals, likewise.
        mean_current_a: over the last 20 s, from the battery's RC pair.
        remaining_s: time until empty at the mean current; None while it does not drain.
        is_charging: the current flows into the battery.
    """

    consumed_mah: float
    consumed_j: float
    mean_current_a: float
    remaining_s: float | None
    is_charging: bool


class Properties(Protocol):
    """The properties of a JSBSim instance, by name."""

    def __getitem__(self, name: str) -> float: ...

    def __setitem__(self, name: str, value: float) -> None: ...


class Battery:
    """The battery in a running JSBSim.

    Args:
        fdm: JSBSim with the airframe loaded.
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
        """Sets the state of charge, 0 to 1; this does not count as consumption."""
        self._full_charge += charge - self._fdm["battery/charge"]
        self._fdm["battery/charge"] = charge

    def age(self, capacity: float | None, resistance: float | None) -> None:
        """Replaces the pack by one of another age with the same charge; None keeps a property.

        Args:
            capacity: as a share of a new pack's.
            resistance: as a multiple of a new pack's.
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

        The current is constant until the terminals reach 16.8 V; then the voltage is constant and
        the current falls until the battery is full.
        """
        return self._fdm["battery/charging-a"]

    @charging_a.setter
    def charging_a(self, value: float) -> None:
        self._fdm["battery/charging-a"] = value

    @property
    def is_draining(self) -> bool:
        """Whether the vehicle's own current reduces the charge; a charger's current always adds to
        it.
        """
        return self._is_draining

    @is_draining.setter
    def is_draining(self, value: bool) -> None:
        self._is_draining = value
        self._fdm["battery/is-draining"] = float(value)

    @property
    def _capacity_as(self) -> float:
        return CAPACITY_AH * 3600 * self.capacity

    def _since_mah(self) -> float:
        """Charge drawn since the pack's last change."""
        return (self._full_charge - self._fdm["battery/charge"]) * self._capacity_as / 3.6
