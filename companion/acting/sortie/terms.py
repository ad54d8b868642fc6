"""What the operator has decided beforehand for each sortie."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.sortie.flight_limit import NO_LIMIT, FlightLimit
from companion.acting.sortie.preflight.arming_terms import USUAL_ARMING, ArmingTerms


@dataclass(frozen=True, slots=True)
class SortieTerms:
    """The terms on which a vehicle is armed, continues a flight, and is called home.

    Attributes:
        arming: the terms for arming.
        limit: when it is called home.
        resumes: whether it continues without an operator if the autopilot holds because it no
            longer heard us.
    """

    arming: ArmingTerms = USUAL_ARMING
    limit: FlightLimit = NO_LIMIT
    resumes: bool = False


USUAL_TERMS = SortieTerms()
