"""How much room a route leaves: from the vehicle's centre to the nearest obstacle."""

from __future__ import annotations

RADIUS_M = 0.35  # of the vehicle
MARGIN_M = 0.10
"""What has to stay free beside the vehicle, wherever it really flies."""
DEVIATION_M = 0.15
"""How much nearer than its route it may come: tracking, map cells, the way to a stop."""
CLEARANCE_M = RADIUS_M + MARGIN_M + DEVIATION_M
