"""All that a process needs to fly rows of a campaign, as bytes, and the header of its table.

The kit is made once, where the files are, and sent to other processes and machines. They need the
same release installed, but no files.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from companion.campaigns.environment import environment_of
from companion.mission.digest import digest
from companion.mission.model import Mission

if TYPE_CHECKING:
    from companion.flights.simulated_world import Factor, VariedScenario

FORMAT = "1"
"""Version of the table's and rows.jsonl's format."""


@dataclass(frozen=True)
class Kit:
    """A mission, the scenario of its rows, and the environment that flies them.

    Attributes:
        limit_s: simulated seconds after which a flight is cut off.
        environment: where the kit was made; in another environment, flights would differ.
    """

    mission: Mission
    scenario: VariedScenario
    limit_s: float
    environment: Mapping[str, str]

    @classmethod
    def of(cls, mission: Mission, scenario: VariedScenario, limit_s: float) -> Kit:
        """The kit in the environment of this process."""
        return cls(mission, scenario, limit_s, dict(environment_of(mission)))

    @property
    def factors(self) -> tuple[Factor, ...]:
        """The factors of the scenario."""
        return self.scenario.factors

    @cached_property
    def packed(self) -> bytes:
        """The kit as bytes."""
        return zlib.compress(pickle.dumps(self))

    @classmethod
    def unpacked(cls, packed: bytes) -> Kit:
        """The kit from bytes that this program has packed."""
        kit = pickle.loads(zlib.decompress(packed))
        assert isinstance(kit, cls)
        return kit

    def header(self, seed: int, **about: object) -> dict[str, str]:
        """The header of a table: all that its rows depend on.

        Args:
            seed: the seed of the campaign.
            about: further lines, such as the number of rows.
        """
        varied = {f"vary {f.path}": str(f.distribution) for f in self.factors}
        return {
            "format": FORMAT,
            "mission": f"{self.mission.name} {digest(self.mission)[:16]}",
            "scenario": self._hash_of_scenario(),
            **varied,
            "seed": str(seed),
            "limit_s": f"{self.limit_s:g}",
            **{name: str(value) for name, value in about.items()},
            **self.environment,
        }

    def _hash_of_scenario(self) -> str:
        hashed = hashlib.sha256(json.dumps(self.scenario.portable, sort_keys=True).encode())
        if (grid := self.scenario.grid) is not None:
            hashed.update(repr((grid.occupied.shape, grid.cell_m, grid.origin)).encode())
            hashed.update(grid.occupied.tobytes())
        return hashed.hexdigest()[:16]
