"""What becomes of a file that a ground station uploads?

A mission (a YAML file that is neither a map nor a vehicle profile) is checked and planned as soon
as it is complete, together with the files that are there by then; so these and PDDL go first.
Rules:
1. Checked is a copy (`checking/N`), in a child process, one at a time; nobody waits for it.
2. A mission that can be flown becomes `active/N`, with its files, in one step. One that cannot
   changes nothing but the verdict.
3. Each verdict is told once by `poll`, and stands in `verdict.json` for clients to read.
4. A mission ends with a line break. One that does not was cut off: a client that gives up ends its
   session as one that is done, and what is left of a mission may be another one.
5. The newest accepted mission is handed out by `take_active`, for which the caller chooses the
   time: on the ground.
6. A mission that was accepted bears a mark until it is flown. After a restart the newest one, if it
   has its mark, is checked again, as if it had just come: the program may be another one now, and
   the disk may have lost a part.

A door: it moves folders. An example of its use, by whoever has the link and the clock:

    uploads = Uploads(folder)
    for payload in uploads.ftp(now_s, (255, 190), message.payload): ...  # reply to 255, 190
    for verdict in uploads.poll(now_s, is_flying): ...                   # say verdict.text
    if not is_flying and (path := uploads.take_active()): ...            # load_mission(path)
    uploads.flown()                                                      # once it is started
    uploads.close()
"""

from __future__ import annotations

import contextlib
import json
import re
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from companion.ground.checking import Answer, Check, ChildCheck
from companion.ground.ftp import FtpServer
from companion.ground.ftp_sessions import Client
from companion.ground.mission_store import VERDICT, MissionStore, names_of
from companion.mavlink.ftp_frames import Refusal, crc32

CHECK_S = 30.0
CUT_OFF = "the last line has no line break, so a part may be missing; end it with one"
_NO_MISSION = re.compile(rb"""^["']?(image|radius_m)["']?[ \t]*:""", re.MULTILINE)
"""A key that maps have, or vehicle profiles, and missions only deeper inside."""
FORMAT_VERSION = 1
"""Of verdict.json."""
MARK = ".not-flown"
"""In the folder of an accepted mission that was not flown: a file with the mission's path.
No client can say its name, and it is not copied."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was found about an uploaded mission.

    Attributes:
        number: counts the verdicts.
        mission: its path, as it was uploaded.
        crc32: of its content, as CalcFileCRC32 gives it.
        text: one line for people: that it is accepted, or what is wrong and where.
        details: the plan, or all that was said about what is wrong.
    """

    number: int
    mission: str
    crc32: int
    is_accepted: bool
    text: str
    details: str

    def as_json(self) -> bytes:
        """What stands in verdict.json."""
        return json.dumps({"version": FORMAT_VERSION} | asdict(self), indent=2).encode()


@dataclass
class _Running:
    """A check under way."""

    number: int
    mission: str
    crc32: int
    folder: Path
    deadline_s: float
    is_again: bool
    check: Check | None = None
    is_late: bool = False


class Uploads:
    """The files of ground stations, and the missions among them.

    Args:
        root: the folder for all of it; made if missing.
        begin: starts the check of a mission in a folder.
    """

    def __init__(self, root: Path, begin: Callable[[Path, str], Check] = ChildCheck) -> None:
        root = root.resolve()
        self._store = MissionStore(root / "incoming")
        self._server = FtpServer(self._store)
        self._checking, self._active = root / "checking", root / "active"
        shutil.rmtree(self._checking, ignore_errors=True)
        self._checking.mkdir()
        self._active.mkdir(exist_ok=True)
        self._begin = begin
        self._number = self._last_number()
        self._waiting = self._not_flown()
        self._running: _Running | None = None
        self._accepted: Path | None = None
        self._taken: Path | None = None

    def ftp(self, now_s: float, client: Client, payload: bytes) -> list[bytes]:
        """Answers a FILE_TRANSFER_PROTOCOL payload of (system, component) with payloads for it."""
        return self._server.receive(now_s, client, payload)

    def poll(self, now_s: float, is_flying: bool = False) -> list[Verdict]:
        """Goes on with the checks; the verdicts that are new. Does not wait."""
        self._notice()
        verdicts: list[Verdict] = []
        if self._running is not None:
            verdicts += self._finish(self._running, now_s, is_flying)
        if self._running is None and self._waiting:
            verdicts += self._start(*self._waiting.pop(0), now_s)
        for verdict in verdicts:
            self._publish(verdict)
        return verdicts

    def take_active(self) -> Path | None:
        """The mission that was accepted last, if it was not taken yet; older ones are deleted."""
        taken, self._accepted = self._accepted, None
        if taken is not None:
            self._taken = taken
            for folder in self._active.iterdir():
                if not taken.is_relative_to(folder):
                    shutil.rmtree(folder, ignore_errors=True)
        return taken

    def flown(self) -> None:
        """The mission that was taken last is flown: it is not offered again after a restart."""
        taken, self._taken = self._taken, None
        if taken is not None:
            number = taken.relative_to(self._active).parts[0]
            with contextlib.suppress(OSError):  # then it is offered once more
                (self._active / number / MARK).unlink()

    def close(self) -> None:
        """Ends a check that is under way."""
        if self._running is not None and self._running.check is not None:
            self._running.check.kill()

    def _notice(self) -> None:
        """Queues the missions among the files that are new; one that came twice is read once."""
        stored = dict.fromkeys("/".join(names_of(path)) for path in self._server.stored)
        self._server.stored.clear()
        for name in stored:
            if (self._store, name) not in self._waiting and self._is_mission(name):
                self._waiting.append((self._store, name))

    def _is_mission(self, name: str) -> bool:
        try:
            is_yaml = name.endswith((".yaml", ".yml"))
            return is_yaml and not _NO_MISSION.search(self._store.read(name))
        except Refusal:  # it is gone again
            return False

    def _start(self, store: MissionStore, mission: str, now_s: float) -> list[Verdict]:
        self._number += 1
        folder, is_again = self._checking / str(self._number), store is not self._store
        running = _Running(self._number, mission, 0, folder, now_s + CHECK_S, is_again)
        try:
            store.copy_to(folder)
            content = (folder / mission).read_bytes()
            running.crc32 = crc32(content)
            if not content.endswith(b"\n"):
                return [self._refuse(running, CUT_OFF)]
            running.check = self._begin(folder, mission)
        except (OSError, Refusal) as error:
            return [self._refuse(running, f"it cannot be checked: {error}")]
        self._running = running
        return []

    def _finish(self, running: _Running, now_s: float, is_flying: bool) -> list[Verdict]:
        try:
            answer = running.check.poll() if running.check else None
        except OSError as error:
            answer = Answer(False, f"it cannot be checked: {error}")
        if answer is None:
            if running.check and now_s > running.deadline_s and not running.is_late:
                running.is_late = True
                running.check.kill()
            return []
        self._running = None
        if answer.is_good:
            return [self._activate(running, answer.text, is_flying)]
        return [self._refuse(running, answer.text)]

    def _activate(self, running: _Running, plan: str, is_flying: bool) -> Verdict:
        """Moves a mission that can be flown to where it is taken from."""
        folder = self._active / str(running.number)
        try:
            (running.folder / MARK).write_text(running.mission, encoding="utf-8")
            running.folder.rename(folder)
        except OSError as error:
            return self._refuse(running, f"it cannot be made active: {error}")
        self._accepted = folder / running.mission
        again = " again after a restart" if running.is_again else ""
        when = "; becomes active after landing" if is_flying else ""
        text = f"{running.mission} accepted{again}{when}"
        return Verdict(running.number, running.mission, running.crc32, True, text, plan)

    def _refuse(self, running: _Running, reason: str) -> Verdict:
        """Leaves everything as it was."""
        shutil.rmtree(running.folder, ignore_errors=True)
        first, mission = (reason.splitlines() or ["?"])[0], running.mission
        text = f"refused {first if mission in first else f'{mission}: {first}'}"
        return Verdict(running.number, mission, running.crc32, False, text, reason)

    def _publish(self, verdict: Verdict) -> None:
        try:
            self._store.publish(verdict.as_json())
        except Refusal:  # the disk is full; it is told all the same
            return

    def _last_number(self) -> int:
        """Numbers go on after a restart, so that clients see a new verdict as one."""
        newest = max(self._numbers(), default=0)
        try:
            return max(newest, int(json.loads(self._store.read(VERDICT))["number"]))
        except (Refusal, ValueError, KeyError, TypeError):
            return newest

    def _numbers(self) -> list[int]:
        """Of the missions that were accepted and are still there."""
        return [int(f.name) for f in self._active.iterdir() if f.name.isdecimal()]

    def _not_flown(self) -> list[tuple[MissionStore, str]]:
        """The newest mission that was accepted, if it has its mark."""
        folder = self._active / str(max(self._numbers(), default=0))
        try:
            mission = (folder / MARK).read_text(encoding="utf-8")
        except (OSError, ValueError):
            return []
        return [(MissionStore(folder), mission)]
