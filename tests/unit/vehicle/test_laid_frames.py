"""A frame goes on where it was laid, for as long as its autopilot is not restarted."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from companion.geometry import GlobalOrigin, Ned
from companion.vehicle.laid_frames import MOST_FRAMES, SAME_BOOT_S, LaidFrame, LaidFrames
from companion.vehicle.mission_frame import SETTLING_S, MissionFrame

HOME: Ned = (10.0, 20.0, 0.1)
BESIDE: Ned = (10.8, 20.6, 0.1)
HERE = GlobalOrigin(47.0, 8.0, 480.0)
EPSILON_S = 0.1


class Computer:
    """Whose clock a test sets."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.kept: Sequence[LaidFrame] = ()

    def program(self) -> LaidFrames:
        """What a program remembers that starts now."""
        return LaidFrames(lambda: self.now_s, self.kept, self._keep)

    def _keep(self, laid: Sequence[LaidFrame]) -> None:
        self.kept = tuple(laid)


def standing_at(local: Ned, reference: GlobalOrigin | None = None) -> MissionFrame:
    """A vehicle stands there, as long as it takes."""
    frame = MissionFrame()
    frame.take_home(local, 488.0)
    if reference is not None:
        frame.take_reference(reference)
    for now_s in (0.0, SETTLING_S):
        frame.take_position(now_s, local, is_standing=True)
    return frame


def laid_at_home(computer: Computer, reference: GlobalOrigin | None = None) -> None:
    """An earlier program's flight; its autopilot booted 100 s ago."""
    frame = standing_at(HOME, reference)
    frame.lay((0.0, 0.0, -2.0))
    computer.program().note(frame, system=1, boot_s=100.0)


def test_the_next_program_goes_on_with_the_frame() -> None:
    computer = Computer()
    laid_at_home(computer)
    computer.now_s += 500.0
    frame = standing_at(BESIDE)
    computer.program().recall(frame, system=1, boot_s=600.0)
    assert frame.is_recalled
    frame.lay((0.0, 0.0, -2.0))
    assert (frame.origin, frame.altitude_m) == (HOME, 488.0)
    assert frame.gap_m((0.0, 0.0, -2.0), accuracy_m=0.3) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("system", "boot_s", "is_known"),
    [
        (1, 600.0 + SAME_BOOT_S - EPSILON_S, True),
        (1, 600.0 - SAME_BOOT_S + EPSILON_S, True),
        (1, 600.0 - SAME_BOOT_S - EPSILON_S, False),
        (1, 30.0, False),  # it was restarted
        (2, 600.0, False),
    ],
)
def test_another_vehicle_or_another_boot_has_a_frame_of_its_own(
    system: int, boot_s: float, is_known: bool
) -> None:
    computer = Computer()
    laid_at_home(computer)
    computer.now_s += 500.0
    frame = standing_at(BESIDE)
    computer.program().recall(frame, system, boot_s)
    assert frame.is_recalled is is_known
    frame.lay((0.0, 0.0, -2.0))
    assert frame.origin == (HOME if is_known else BESIDE)


@pytest.mark.parametrize("is_heard_first", [True, False])
def test_an_origin_that_has_moved_between_two_programs_leaves_it_where_it_was_on_the_earth(
    is_heard_first: bool,
) -> None:
    computer = Computer()
    laid_at_home(computer, HERE)
    there = GlobalOrigin(*HERE.to_global((300.0, -400.0, 0.0)))
    frame = standing_at((-289.2, 420.6, 0.1), there if is_heard_first else None)
    computer.program().recall(frame, system=1, boot_s=100.0)
    if not is_heard_first:
        frame.take_reference(there)
    assert frame.origin == pytest.approx((-290.0, 420.0, 0.1), abs=0.05)


def test_a_frame_that_is_laid_is_not_laid_elsewhere() -> None:
    computer = Computer()
    laid_at_home(computer)
    frame = standing_at(BESIDE)
    frame.lay((0.0, 0.0, -2.0))
    computer.program().recall(frame, system=1, boot_s=100.0)
    assert frame.origin == BESIDE and not frame.is_recalled


def test_a_mission_in_latitude_and_longitude_leaves_no_frame() -> None:
    computer = Computer()
    frame = standing_at(HOME, HERE)
    frame.anchor_at(HERE)
    frame.lay((0.0, 0.0, -2.0))
    computer.program().note(frame, system=1, boot_s=100.0)
    assert not computer.kept


def test_the_same_frame_is_kept_once_and_the_newest_ones_alone() -> None:
    computer = Computer()
    laid_at_home(computer)
    computer.now_s += 500.0
    again, boot_s = standing_at(BESIDE), 100.0 + 500.0 - SAME_BOOT_S / 2
    program = computer.program()
    program.recall(again, system=1, boot_s=boot_s)
    program.note(again, system=1, boot_s=boot_s)
    (kept,) = computer.kept
    assert kept.laid.local == HOME
    assert kept.booted_s == computer.now_s - boot_s, "as it is reckoned now"
    for _ in range(MOST_FRAMES + 3):
        computer.now_s += 1000.0
        laid_at_home(computer)
    assert len(computer.kept) == MOST_FRAMES
    assert computer.kept[-1].booted_s == computer.now_s - 100.0
