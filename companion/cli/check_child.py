"""Checks one mission from an untrusted source, in a confined process, and ends.

    python -P -m companion.cli.check_child

1. It confines itself, loads everything, and waits for a line of JSON on its standard input: a
   folder, a mission in it, the installed functions, and whether other programs are heard.
2. It writes lines of JSON: `doing` says what is begun, and the last line is the answer, as
   `companion check --json` prints it.
3. Without an order it ends when none can arrive any more. `companion/ground/checking.py` is the
   other side.
4. The cost of a check is counted and not measured, so the answer is the same on every machine: at
   most `WORK_S` of rated work (`slices.py`). For what is not counted, the system limits memory,
   processor time and file size.
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
"""Its own memory; with mapped libraries it has at most 512 MiB."""
CPU_S = 10
WORK_S = 6
NICENESS = 10
ANSWER_BYTES = 32 * MIB
"""Memory kept free, so that it can still report that there is no memory left."""
ADVICE = "simplify the task, or use fewer places, or larger cells of the map"


class _TimeIsOver(BaseException):
    """Raised by the signal for the end of the processor time."""


class BoundedCheck:
    """The check of a mission in the working directory.

    Args:
        work_s: limit of rated work.
        installed: the functions that the mission may call; none is loaded here.
        hears_reports: whether reports of other programs are received.
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
        # Keeps the data of a search until the answer is out, because freeing it may take a second.
        self._given_up_by: BaseException | None = None

    def answer(self) -> dict[str, Any]:
        """The result of the check, in JSON values."""
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
            return self._given_up(f"{sys.getrecursionlimit()} nested calls")

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
        os.chdir(folder)  # the module search path is unchanged: nothing is imported from there
        check = BoundedCheck(Path(mission), WORK_S, from_json(installed), hears_reports)
        _write(check.answer())
        os._exit(0)  # without freeing everything


if __name__ == "__main__":
    main()
