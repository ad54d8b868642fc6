"""Checks one mission of a stranger, in a process that cannot do much harm, and ends.

    python -P -m companion.cli.check_child

It confines itself, and waits with everything loaded for a line of JSON on its standard input: a
folder, a mission in it, the functions that are installed, and whether other programs are heard. It
writes lines of JSON: `doing` says what is begun, and the last line is the answer, as `companion
check --json` prints it. Without an order it ends when nobody can give one any more.
`companion/ground/checking.py` is the other side.

What a check may take is counted and not measured, so that the answer is the same on every machine:
`WORK_S` of work, as rated (`slices.py`). Beyond that are the limits of the system, on memory,
processor time and the size of files, for what is not counted.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from functools import partial
from pathlib import Path
from types import FrameType, MappingProxyType
from typing import Any

from companion.cli.checked_mission import CheckedMission, check_mission
from companion.cli.checking import refusal_as_json
from companion.cli.planning import FORMAT_VERSION
from companion.errors import CompanionError
from companion.ground.checking import MAX_OUTPUT_BYTES
from companion.mission.kept_domain import read_and_keep
from companion.python_child import MIB, confine_memory, confine_time
from companion.skills.catalogue import Catalogue, from_json
from companion.slices import InSlices

MEMORY_BYTES = 448 * MIB
"""Of its own; with the libraries that it maps it has at most 512 MiB."""
CPU_S = 10
WORK_S = 6
NICENESS = 10
ANSWER_BYTES = 32 * MIB
"""Kept free, so that there is memory left to say that there is none."""
ADVICE = "simplify the task, or use fewer places, or larger cells of the map"


class _TimeIsOver(BaseException):
    """Raised by the signal that comes when the processor time is over."""


class BoundedCheck:
    """The check of one mission in the working directory.

    Args:
        work_s: of work, as rated.
        installed: the functions that the mission may call; none is loaded here.
        hears_reports: whether what other programs report is heard.
    """

    def __init__(
        self,
        mission: Path,
        work_s: float = WORK_S,
        installed: Catalogue = MappingProxyType({}),
        hears_reports: bool = True,
    ) -> None:
        self._hears_reports = hears_reports
        self._mission, self._work_s, self._installed = mission, work_s, installed
        self._doing = ""
        self._for_the_answer = bytearray(ANSWER_BYTES)
        # Keeps what a search has made until the answer is out: to free it may take a second.
        self._given_up_by: BaseException | None = None

    def answer(self) -> dict[str, Any]:
        """What is found out, in JSON values."""
        try:
            return {"version": FORMAT_VERSION, "ok": True} | self._checked().as_json()
        except CompanionError as error:
            return refusal_as_json(error)
        except MemoryError as error:
            self._for_the_answer.clear()
            self._given_up_by = error
            return self._given_up(f"{MEMORY_BYTES // MIB} MiB of memory")
        except _TimeIsOver as error:
            self._given_up_by = error
            return self._given_up(f"{CPU_S} s of processor time")
        except RecursionError:
            return self._given_up(f"{sys.getrecursionlimit()} calls in one another")

    def _checked(self) -> CheckedMission:
        check = partial(
            check_mission,
            self._mission,
            within=Path(),
            tell=self._tell,
            domain_of=read_and_keep,
            installed=lambda _: self._installed,
            hears_reports=self._hears_reports,
        )
        checking = InSlices(check, self._work_s * 1e6)
        if not checking.step():
            checking.abandon()
            raise _limit(f"{self._work_s:g} s of work", self._doing)
        return checking.result

    def _tell(self, doing: str) -> None:
        self._doing = doing
        _write({"doing": doing})

    def _given_up(self, limit: str) -> dict[str, Any]:
        return refusal_as_json(_limit(limit, self._doing))


def _limit(limit: str, doing: str) -> CompanionError:
    return CompanionError(
        f"it takes more than {limit} to check it; given up at {doing}\n    {ADVICE}"
    )


def _write(line: dict[str, Any]) -> None:
    print(json.dumps(line), flush=True)


def _stop(number: int, frame: FrameType | None) -> None:
    raise _TimeIsOver


def main() -> None:
    """Entry point."""
    confine_memory(MEMORY_BYTES)
    resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_OUTPUT_BYTES, MAX_OUTPUT_BYTES))
    os.nice(NICENESS)
    order = sys.stdin.buffer.readline()
    if order:
        folder, mission, installed, hears_reports = json.loads(order)
        signal.signal(signal.SIGXCPU, _stop)
        confine_time(CPU_S)
        os.chdir(folder)  # the module search path stays as it was: nothing is imported from there
        check = BoundedCheck(Path(mission), WORK_S, from_json(installed), hears_reports)
        _write(check.answer())
        os._exit(0)  # nothing is freed one by one


if __name__ == "__main__":
    main()
