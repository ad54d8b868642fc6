"""Checks hostile uploads by their seeds, each in a child process as an upload is checked in.

    python tests/faults/hostile_checks.py mission 0 500

prints each upload that was not answered as it should be, with the command that repeats it, and a
last line with the greatest figures. With one seed it prints the answer; its files stay in the
folder that is printed. The children are forked with everything loaded, as the one is that a
companion keeps ready.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from hostile import MISSION, hostile

from companion.cli import check_child
from companion.ground.checking import CheckResult, result_of

MOST_CPU_S, MOST_MB = 10.5, 512.0  # half a second to end after the signal
UNCLEAR = ("the check has failed", "the check was ended", "Traceback", "Error:")
"""What no refusal may begin with, or have in it."""


@dataclass(frozen=True)
class Answer:
    """What became of a check.

    Attributes:
        cpu_s: of the child.
        peak_mb: its memory at most, with all that it maps.
    """

    result: CheckResult
    cpu_s: float
    peak_mb: float

    @property
    def fault(self) -> str | None:
        """What is wrong with it; None if nothing is."""
        if self.cpu_s > MOST_CPU_S:
            return f"took {self.cpu_s:.1f} s"
        if self.peak_mb > MOST_MB:
            return f"took {self.peak_mb:.0f} MB"
        text = self.result.text
        if not text.strip() or (not self.result.is_good and any(word in text for word in UNCLEAR)):
            return f"is no clear answer: {text}"
        return None


def checked(kind: str, seed: int, folder: Path) -> Answer:
    """The answer to the upload of a seed; its files are left in the folder."""
    hostile(kind, seed).write(folder)
    order, give = os.pipe()
    answers, say = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(order, 0)
        os.dup2(say, 1)
        for end in (order, give, answers, say):
            os.close(end)
        _be_child()
    os.close(order)
    os.close(say)
    os.write(give, json.dumps([str(folder), MISSION, [], False]).encode() + b"\n")
    os.close(give)
    with os.fdopen(answers, "rb") as stream:
        printed = stream.read()
    _, status, used = os.wait4(child, 0)
    result = result_of(os.waitstatus_to_exitcode(status), printed)
    return Answer(result, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def _be_child() -> None:
    """The rest of a forked process."""
    sys.stdin, sys.stdout = os.fdopen(0, "r"), os.fdopen(1, "w")
    code = 1
    try:
        check_child.main()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def faults(kind: str, seeds: Iterable[int]) -> list[str]:
    """The uploads that were not answered as they should be, with the command that repeats each."""
    found, longest_s, largest_mb, answers = [], 0.0, 0.0, Counter[bool]()
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            answer = checked(kind, seed, Path(folder))
        longest_s, largest_mb = max(longest_s, answer.cpu_s), max(largest_mb, answer.peak_mb)
        answers[answer.result.is_good] += 1
        if answer.fault:
            command = f"python tests/faults/hostile_checks.py {kind} {seed}"
            found.append(f"{command}  # {answer.fault}")
    print(
        f"{answers[True]} accepted, {answers[False]} refused, at most {longest_s:.1f} s and "
        f"{largest_mb:.0f} MB"
    )
    return found


def main() -> None:
    """Entry point."""
    kind, *numbers = sys.argv[1:]
    if len(numbers) == 1:
        folder = Path(tempfile.mkdtemp(prefix="hostile-"))
        answer = checked(kind, int(numbers[0]), folder)
        print(folder, answer, answer.result.text, sep="\n")
        sys.exit(answer.fault)
    if found := faults(kind, range(*map(int, numbers))):
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
