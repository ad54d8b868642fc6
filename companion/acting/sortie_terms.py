"""What the operator has said beforehand of each sortie."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.flight_limit import NO_LIMIT, FlightLimit
from companion.acting.preflight.arming_terms import USUAL_ARMING, ArmingTerms


@dataclass(frozen=True, slots=True)
class SortieTerms:
    """On which terms a vehicle is armed, flies on, and is called home.

    Attributes:
        arming: on which it is armed.
        limit: after what it is called home.
        resumes: it flies on without an operator where the autopilot holds because it no longer
            heard us.
    """

    arming: ArmingTerms = USUAL_ARMING
    limit: FlightLimit = NO_LIMIT
    resumes: bool = False


USUAL_TERMS = SortieTerms()
