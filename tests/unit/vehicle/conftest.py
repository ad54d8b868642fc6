"""A vehicle over MAVLink that has met a scripted autopilot."""

from __future__ import annotations

import pytest
from autopilot import CALL, CHARGE, ENVELOPE, TARGET, Meeting


@pytest.fixture
def meeting() -> Meeting:
    return Meeting(ENVELOPE, frozenset({TARGET, CHARGE, CALL}))
