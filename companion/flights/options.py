"""What a program decides about its flights before the first one begins."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.sortie.terms import USUAL_TERMS, SortieTerms
from companion.mavlink.signing import Signing
from companion.planning.engine_port import Engine
from companion.vehicle.endpoints import Endpoint
from companion.vehicle.link import Link
from companion.vehicle.report_port import place_of


@dataclass(frozen=True)
class FlightOptions:
    """How missions are flown, over a link or in lockstep.

    Attributes:
        terms: what the operator has decided for each sortie.
        engine: plans; None for the built-in search.
    """

    terms: SortieTerms = USUAL_TERMS
    engine: Engine | None = None


USUAL_OPTIONS = FlightOptions()


@dataclass(frozen=True)
class LinkOptions:
    """What connects flights with their vehicle.

    Attributes:
        endpoint: our end of the link.
        signing: signs and verifies the frames; None for a link without signatures.
        events: where other programs on board report events, `unix:PATH` or `udpin:HOST:PORT`;
            None if nowhere.
        timeout_s: how long a flight waits for its vehicle, in seconds of the flight's clock.
        speed: the speed of the flight's clock at the start, as a multiple of real time.

    Raises:
        AddressError: `events` has neither form.
    """

    endpoint: Endpoint
    signing: Signing | None = None
    events: str | None = None
    timeout_s: float = 30.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        """Refuses an invalid address before anything is opened."""
        if self.events is not None:
            place_of(self.events)

    def open(self) -> Link:
        """Opens the link.

        Raises:
            LinkError: the port cannot be opened.
        """
        return Link(self.endpoint, self.signing)
