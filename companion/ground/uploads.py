"""Queues, checks, and accepts or refuses the missions that ground stations upload; hands them out.

A mission (a YAML file that is neither a map nor a vehicle profile) is checked and planned as soon
as it is complete, with the files that are there by then. So its maps, profiles and PDDL have to be
sent first. `upload_states.py` has the states of a mission. Rules about the files:
1. A copy (`checking/N`) is checked, in a child process; nobody waits for it.
2. A mission that can be flown becomes `active/N`, with its files, in one step. A mission that
   cannot be flown changes only the verdict.
3. `poll` returns each verdict once; `verdict.json` has the newest one for clients to read.
4. A mission file has to end with a line break; otherwise it was cut off. A client that gives up
   ends its session like one that is done, and the beginning of a mission may be another valid
   mission.
5. `take_active` hands out the accepted mission; the caller chooses the time: on the ground.
6. An accepted mission has a mark until it is started. After a restart the newest one, if it has its
   mark, is checked again: the program may have been updated, and the disk may have lost a part.

A door: it moves folders. An example of its use, by whoever has the link and the clock:

    uploads = Uploads(folder)
    for payload in uploads.ftp(now_s, (255, 190), message.payload): ...  # reply to 255, 190
    for verdict in uploads.poll(now_s, is_flying): ...                   # say verdict.text
    if not is_flying and (path := uploads.take_active()): ...            # load_mission(path)
    uploads.started()                                                    # once it is started
    uploads.close()
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from companion.ground.checking import CheckResult, MissionCheck, begin_check
from companion.ground.ftp import FtpServer
from companion.ground.ftp_sessions import Client
from companion.ground.mission_store import VERDICT, MissionStore, names_of
from companion.ground.upload_names import MISSION_ENDINGS
from companion.ground.upload_states import (
    IN_CHECK,
    TRANSITIONS,
    UploadState,
    UploadTrigger,
    UploadVerdict,
)
from companion.mavlink.ftp_frames import FtpRefusal, crc32

CHECK_S = 30.0
CUT_OFF = "the last line has no line break, so a part may be missing; end it with one"
NO_LINES = "it is not UTF-8 text whose lines end with LF (\\n); save it as that"
_NO_MISSION = re.compile(rb"""^["']?(image|radius_m)["']?[ \t]*:""", re.MULTILINE)
"""A top-level key that only maps or vehicle profiles have."""
MARK = ".not-flown"
"""A file in the folder of an accepted mission that was not started; it contains the mission's path.
No client can use its name, and it is not copied."""

log = logging.getLogger(__name__)


@dataclass
class _Upload:
    """One uploaded mission.

    Attributes:
        number: of its verdict.
        mission: its path, as it was uploaded.
        store: where its files are while it is queued.
        folder: of its copy: while under check, and then where it is taken from.
        is_again: whether it was found after a restart.
    """

    number: int
    mission: str
    store: MissionStore
    folder: Path
    state: UploadState
    is_again: bool
    crc32: int = 0
    deadline_s: float = math.inf
    check: MissionCheck | None = None

    def verdict(
        self, is_accepted: bool, text: str, details: str, notices: tuple[str, ...] = ()
    ) -> UploadVerdict:
        """Returns the verdict on it."""
        return UploadVerdict(
            number=self.number,
            mission=self.mission,
            crc32=self.crc32,
            is_accepted=is_accepted,
            text=text,
            details=details,
            notices=notices,
        )


class Uploads:
    """The files of ground stations, and the missions among them.

    Args:
        root: the folder for everything; created if missing.
        begin: starts the check of a mission in a folder.
    """

    def __init__(
        self, root: Path, begin: Callable[[Path, str], MissionCheck] = begin_check
    ) -> None:
        root = root.resolve()
        self._store = MissionStore(root / "incoming")
        self._server = FtpServer(self._store)
        self._checking, self._active = root / "checking", root / "active"
        shutil.rmtree(self._checking, ignore_errors=True)
        self._checking.mkdir()
        self._active.mkdir(exist_ok=True)
        self._begin = begin
        self._number = self._last_number()
        self._uploads: list[_Upload] = []
        self._find_not_started()

    def ftp(self, now_s: float, client: Client, payload: bytes) -> list[bytes]:
        """Answers a FILE_TRANSFER_PROTOCOL payload of (system, component) with payloads for it."""
        return self._server.receive(now_s, client, payload)

    def poll(self, now_s: float, is_flying: bool = False) -> list[UploadVerdict]:
        """Advances the checks and returns the new verdicts. Does not wait."""
        self._notice()
        verdicts: list[UploadVerdict] = []
        for upload in self._all_in(*IN_CHECK):
            verdicts += self._follow_check(upload, now_s, is_flying)
        if not self._all_in(*IN_CHECK):
            for upload in self._all_in(UploadState.QUEUED)[:1]:
                verdicts += self._begin_check(upload, now_s)
        for verdict in verdicts:
            self._publish(verdict)
        return verdicts

    @property
    def has_waiting(self) -> bool:
        """Whether an accepted mission waits for `take_active`."""
        return bool(self._all_in(UploadState.ACCEPTED))

    def take_active(self) -> Path | None:
        """Makes the accepted mission the active one and returns its path; None without one."""
        for upload in self._all_in(UploadState.ACCEPTED):
            for older in self._all_in(UploadState.ACTIVE):
                self._advance(older, UploadTrigger.NEWER_ACTIVE)
            self._advance(upload, UploadTrigger.TAKEN)
            for folder in self._active.iterdir():
                if folder != upload.folder:
                    shutil.rmtree(folder, ignore_errors=True)
            return upload.folder / upload.mission
        return None

    def started(self) -> None:
        """Notes that the active mission is started, so that a restart does not find it again."""
        for upload in self._all_in(UploadState.ACTIVE):
            self._advance(upload, UploadTrigger.STARTED)
            with contextlib.suppress(OSError):  # then it is found once more
                (upload.folder / MARK).unlink()

    def close(self) -> None:
        """Ends the check under way, if any."""
        for upload in self._all_in(*IN_CHECK):
            if upload.check is not None:
                upload.check.kill()

    def _all_in(self, *states: UploadState) -> list[_Upload]:
        """Returns the uploads in some states, in the order in which they were stored."""
        return [upload for upload in self._uploads if upload.state in states]

    def _advance(self, upload: _Upload, event: UploadTrigger) -> None:
        """Moves an upload to its next state, and forgets it if that is final."""
        upload.state = TRANSITIONS.next(upload.state, event)
        if TRANSITIONS.is_final(upload.state):
            self._uploads.remove(upload)

    def _queue(self, mission: str, store: MissionStore, event: UploadTrigger) -> None:
        self._number += 1
        folder, state = self._checking / str(self._number), TRANSITIONS.next(None, event)
        is_again = event is UploadTrigger.FOUND
        self._uploads.append(_Upload(self._number, mission, store, folder, state, is_again))

    def _notice(self) -> None:
        """Queues the missions among the new files; a mission stored twice is queued once."""
        stored = dict.fromkeys("/".join(names_of(path)) for path in self._server.take_stored())
        queued = self._all_in(UploadState.QUEUED)
        waiting = {upload.mission for upload in queued if not upload.is_again}
        for name in stored:
            if name not in waiting and self._is_mission(name):
                self._queue(name, self._store, UploadTrigger.STORED)

    def _is_mission(self, name: str) -> bool:
        try:
            is_yaml = name.endswith(MISSION_ENDINGS)
            return is_yaml and not _NO_MISSION.search(self._store.read(name))
        except FtpRefusal:  # it is gone again
            return False

    def _begin_check(self, upload: _Upload, now_s: float) -> list[UploadVerdict]:
        log.debug("check %d of %s begins", upload.number, upload.mission)
        upload.deadline_s = now_s + CHECK_S
        try:
            upload.store.copy_to(upload.folder)
            content = (upload.folder / upload.mission).read_bytes()
            upload.crc32 = crc32(content)
            if not content.endswith(b"\n"):
                has_lines = b"\n" in content and b"\0" not in content
                why = CUT_OFF if has_lines else NO_LINES
                return [self._refuse(upload, UploadTrigger.UNUSABLE, why)]
            upload.check = self._begin(upload.folder, upload.mission)
        except (OSError, FtpRefusal) as error:
            reason = f"it cannot be checked: {error}"
            return [self._refuse(upload, UploadTrigger.UNUSABLE, reason)]
        self._advance(upload, UploadTrigger.BEGUN)
        return []

    def _follow_check(self, upload: _Upload, now_s: float, is_flying: bool) -> list[UploadVerdict]:
        assert upload.check is not None
        try:
            result = upload.check.poll()
        except OSError as error:
            result = CheckResult(False, f"it cannot be checked: {error}")
        if result is None:
            if now_s > upload.deadline_s and upload.state is UploadState.CHECKING:
                self._advance(upload, UploadTrigger.TIMED_OUT)
                upload.check.kill()
            return []
        if result.is_good:
            return [self._accept(upload, result, is_flying)]
        return [self._refuse(upload, UploadTrigger.FAILED, result.text)]

    def _accept(self, upload: _Upload, found: CheckResult, is_flying: bool) -> UploadVerdict:
        """Moves a mission that can be flown to where it is taken from."""
        folder = self._active / str(upload.number)
        try:
            (upload.folder / MARK).write_text(upload.mission, encoding="utf-8")
            upload.folder.rename(folder)
        except OSError as error:
            return self._refuse(upload, UploadTrigger.FAILED, f"it cannot be made active: {error}")
        upload.folder = folder
        for older in self._all_in(UploadState.ACCEPTED):
            self._advance(older, UploadTrigger.NEWER_ACCEPTED)
        self._advance(upload, UploadTrigger.PASSED)
        again = " again after a restart" if upload.is_again else ""
        when = "; becomes active after landing" if is_flying else ""
        text = f"{upload.mission} accepted{again}{when}"
        return upload.verdict(True, text, found.text, found.notices)

    def _refuse(self, upload: _Upload, event: UploadTrigger, reason: str) -> UploadVerdict:
        """Deletes the copy of a mission that cannot be flown; nothing else changes."""
        self._advance(upload, event)
        shutil.rmtree(upload.folder, ignore_errors=True)
        first, mission = (reason.splitlines() or ["?"])[0], upload.mission
        text = f"refused {first if mission in first else f'{mission}: {first}'}"
        return upload.verdict(False, text, reason)

    def _publish(self, verdict: UploadVerdict) -> None:
        log.debug("check %d: %s", verdict.number, verdict.text)
        try:
            self._store.publish(verdict.as_json())
        except FtpRefusal:  # the disk is full; `poll` returns the verdict even so
            return

    def _last_number(self) -> int:
        """Returns the number of the last verdict before a restart, as a new one has to be
        greater."""
        newest = max(self._numbers(), default=0)
        try:
            return max(newest, int(json.loads(self._store.read(VERDICT))["number"]))
        except (FtpRefusal, ValueError, KeyError, TypeError):
            return newest

    def _numbers(self) -> list[int]:
        """Returns the numbers of accepted missions whose folders still exist."""
        return [int(f.name) for f in self._active.iterdir() if f.name.isdecimal()]

    def _find_not_started(self) -> None:
        """Queues the newest mission that was accepted before a restart, if it has its mark."""
        folder = self._active / str(max(self._numbers(), default=0))
        try:
            mission = (folder / MARK).read_text(encoding="utf-8")
        except (OSError, ValueError):
            return
        self._queue(mission, MissionStore(folder), UploadTrigger.FOUND)
