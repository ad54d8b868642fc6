"""Checks that JSBSim is installed: it has no wheel for Linux on ARM."""

from __future__ import annotations

import platform
import sys
from importlib.util import find_spec

from companion.errors import LibraryMissing


def demand_jsbsim() -> None:
    """Raises an error that says what to do if JSBSim is missing, before any import needs it.

    Raises:
        LibraryMissing: JSBSim is not installed.
    """
    if find_spec("jsbsim") is not None:
        return
    if sys.platform == "linux" and platform.machine() != "x86_64":
        raise LibraryMissing(
            "the simulator needs jsbsim, which has no wheel for Linux on ARM",
            "fly a simulator on another machine: companion run MISSION --connect URL",
        )
    raise LibraryMissing("the simulator needs jsbsim, which is not installed", "pip install jsbsim")
