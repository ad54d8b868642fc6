"""The tick: the period of setpoints, heartbeats and everything else that the companion does."""

TICK_S = 0.05
"""20 Hz."""
