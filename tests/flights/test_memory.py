"""A companion that takes missions has at most 150 MB, in flight and after several uploads.

Missions with PDDL files are among them, whose parser takes 70 MB, and one flight has been drawn.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from ports import free_instance, own_ports
from test_sockets import Run, run

pytestmark = [
    pytest.mark.sockets,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux shows it, in /proc"),
]
__all__ = ["run"]

MISSIONS = Path(__file__).parents[2] / "missions"
MOST_MB = 150.0


def peak_mb(pid: int) -> float:
    """The most memory that a process has had so far, with all libraries."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    assert found is not None
    return int(found[1]) / 1024


@pytest.mark.usefixtures("drawn")
def test_150_mb_are_enough_after_several_uploads(run: Run, tmp_path: Path) -> None:
    number = free_instance()
    run("sitl", *own_ports(number), "--scenario", MISSIONS / "delivery.sim.yaml")
    link = f"udpin://127.0.0.1:{14540 + number}"
    companion = run(
        *("companion", "run", "--connect", link, "--log-dir", tmp_path, "--monitor", "off")
    )
    companion.until_printed("waiting")

    def upload(name: str, *options: str) -> None:
        ground = f"udpin://0.0.0.0:{14550 + number}"
        sent = run("companion", "upload", MISSIONS / f"{name}.yaml", "--connect", ground, *options)
        assert sent.exit_code() == 0, sent.printed

    for name in ("hall_of_20", "persistent_patrol"):
        upload(name)
    upload("delivery", "--start")
    companion.until_printed("at Depot")
    assert peak_mb(companion.pid) <= MOST_MB
    companion.until_printed("results")
    assert (next(tmp_path.glob("*-delivery")) / "flight.png").stat().st_size > 10_000
    upload("surveillance", "--start")
    companion.until_printed("at A")
    assert peak_mb(companion.pid) <= MOST_MB
