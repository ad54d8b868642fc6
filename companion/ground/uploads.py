"""What becomes of a file that a ground station uploads?

A mission (a YAML file that is no map) is checked and planned as soon as it is complete, together
with the files that are there by then; so maps and PDDL go first. Rules:
1. Checked is a copy (`checking/N`), in a child process, one at a time; nobody waits for it.
2. A mission that can be flown becomes `active/N`, with its files, in one step. One that cannot
   changes nothing but the verdict.
3. Each verdict is told once by `poll`, and stands in `verdict.json` for clients to read.
4. A mission ends with a line break. One that does not was cut off: a client that gives up ends its
   session as one that is done, and what is left of a mission may be another one.
5. The newest accepted mission is handed out by `take_active`, for which the caller chooses the
   time: on the ground.

A door: it moves folders. An example of its use, by whoever has the link and the clock:

    uploads = Uploads(folder)
    for payload in uploads.ftp(now_s, (255, 190), message.payload): ...  # reply to 255, 190
    for verdict in uploads.poll(now_s, is_flying): ...                   # say verdict.told
    if not is_flying and (path := uploads.take_active()): ...            # load_mission(path)
    uploads.close()
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from companion.ground.checking import Answer, Check, ChildCheck
from companion.ground.ftp import FtpServer, crc32
from companion.ground.ftp_frames import Refusal
from companion.ground.ftp_sessions import Client
from companion.ground.mission_store import VERDICT, MissionStore, names_of

CHECK_S = 30.0
CUT_OFF = "the last line has no line break, so a part may be missing; end it with one"
_MAP = re.compile(rb"""^["']?image["']?[ \t]*:""", re.MULTILINE)
FORMAT_VERSION = 1
"""Of verdict.json."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was found about an uploaded mission.

    Attributes:
        number: counts the verdicts.
        mission: its path, as it was uploaded.
        crc32: of its content, as CalcFileCRC32 gives it.
        text: when it becomes active and the plan, or what is wrong and where.
    """

    number: int
    mission: str
    crc32: int
    is_accepted: bool
    text: str

    @property
    def told(self) -> str:
        """One line for people."""
        first = self.text.splitlines()[0] if self.text else ""
        if self.is_accepted:
            return first
        return f"refused {first if self.mission in first else f'{self.mission}: {first}'}"

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
    check: Check
    deadline_s: float
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
        self._waiting: list[str] = []
        self._running: _Running | None = None
        self._accepted: Path | None = None

    def ftp(self, now_s: float, client: Client, payload: bytes) -> list[bytes]:
        """Answers a FILE_TRANSFER_PROTOCOL payload of (system, component) with payloads for it."""
        return self._server.receive(now_s, client, payload)

    def poll(self, now_s: float, is_flying: bool = False) -> list[Verdict]:
        """Goes on with the checks; the verdicts that are new. Does not wait."""
        self._notice()
        verdicts = []
        if self._running is not None:
            verdicts += self._finish(self._running, now_s, is_flying)
        if self._running is None and self._waiting:
            verdicts += self._start(self._waiting.pop(0), now_s)
        for verdict in verdicts:
            self._publish(verdict)
        return verdicts

    def take_active(self) -> Path | None:
        """The mission that was accepted last, if it was not taken yet; older ones are deleted."""
        taken, self._accepted = self._accepted, None
        if taken is not None:
            for folder in self._active.iterdir():
                if not taken.is_relative_to(folder):
                    shutil.rmtree(folder, ignore_errors=True)
        return taken

    def close(self) -> None:
        """Ends a check that is under way."""
        if self._running is not None:
            self._running.check.kill()

    def _notice(self) -> None:
        """Queues the missions among the files that are new; one that came twice is read once."""
        stored = dict.fromkeys("/".join(names_of(path)) for path in self._server.stored)
        self._server.stored.clear()
        for name in stored:
            if name not in self._waiting and self._is_mission(name):
                self._waiting.append(name)

    def _is_mission(self, name: str) -> bool:
        try:
            is_yaml = name.endswith((".yaml", ".yml"))
            return is_yaml and not _MAP.search(self._store.read(name))
        except Refusal:  # it is gone again
            return False

    def _start(self, mission: str, now_s: float) -> list[Verdict]:
        self._number += 1
        folder = self._checking / str(self._number)
        checksum = 0
        try:
            self._store.copy_to(folder)
            content = (folder / mission).read_bytes()
            checksum = crc32(content)
            if not content.endswith(b"\n"):
                return [Verdict(self._number, mission, checksum, False, CUT_OFF)]
            check = self._begin(folder, mission)
        except (OSError, Refusal) as error:
            text = f"it cannot be checked: {error}"
            return [Verdict(self._number, mission, checksum, False, text)]
        self._running = _Running(self._number, mission, checksum, folder, check, now_s + CHECK_S)
        return []

    def _finish(self, running: _Running, now_s: float, is_flying: bool) -> list[Verdict]:
        try:
            answer = running.check.poll()
        except OSError as error:
            answer = Answer(False, f"it cannot be checked: {error}")
        if answer is None:
            if now_s > running.deadline_s and not running.is_late:
                running.is_late = True
                running.check.kill()
            return []
        self._running = None
        if answer.is_good:
            answer = self._activate(running, answer, is_flying)
        else:
            shutil.rmtree(running.folder, ignore_errors=True)
        return [
            Verdict(running.number, running.mission, running.crc32, answer.is_good, answer.text)
        ]

    def _activate(self, running: _Running, answer: Answer, is_flying: bool) -> Answer:
        """Moves a mission that can be flown to where it is taken from."""
        folder = self._active / str(running.number)
        try:
            running.folder.rename(folder)
        except OSError as error:
            return Answer(False, f"it cannot be made active: {error}")
        self._accepted = folder / running.mission
        when = "; becomes active after landing" if is_flying else ""
        return Answer(True, f"{running.mission} accepted{when}\n{answer.text}")

    def _publish(self, verdict: Verdict) -> None:
        try:
            self._store.publish(verdict.as_json())
        except Refusal:  # the disk is full; it is told all the same
            return

    def _last_number(self) -> int:
        """Numbers go on after a restart, so that clients see a new verdict as one."""
        try:
            return int(json.loads(self._store.read(VERDICT))["number"])
        except (Refusal, ValueError, KeyError, TypeError):
            return 0
