"""One folder per run: mission, scene, plans, events.jsonl, flight.tlog, clocks.json, flight.png.

- `events.jsonl`: one event per line with `t_s` (seconds since the run began), `kind`, `text` and
  the fields of the event (docs/run-folder.md). It has no wall-clock time, so equal runs give equal
  bytes.
- `scene.json`: what the mission says about the world (scene.py).
- `plan-N.json`: the N-th plan; 0 is the first one, N the one after replan N.
- `flight.tlog`: every MAVLink frame in either direction after eight bytes of time (big-endian
  microseconds since 1970), as MAVProxy and QGroundControl write it. It is written five times per
  second of flight time, so that other programs can follow it.
- `clocks.json`: what the clocks of the run showed at the same time (clocks.py).
- `journal.jsonl`: if asked for, what another process needs to continue the flight
  (journal_file.py).

In flight the loop never waits for the disk: a thread writes (disk_thread.py), the journal has its
own.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.acting.journal import Journal, NoJournal
from companion.flight_events.event import Stamped
from companion.flight_events.hosting import RecordingFailed
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.writing import json_of, line_of
from companion.geometry import Ned
from companion.mavlink.framing import dialect, message_id, split_frames
from companion.mission.model import Mission
from companion.record.clocks import ClockFile
from companion.record.cut_off import ToldWord, cut_events, cut_tlog, write_if_lost
from companion.record.disk_thread import DiskThread
from companion.record.drawing import draw_here
from companion.record.events import EVENTS_FILE, MISSION_FILE, SCENE_FILE, TLOG_FILE
from companion.record.journal_file import JournalFile
from companion.record.scene import scene
from companion.record.tlog_records import TlogRecord
from companion.record.trail import Trail
from companion.vehicle.run_clocks import ClockReading

FLUSH_S = 0.2
MOST_WAITING_BYTES = 32 << 20
"""A quarter of an hour of packets; while this much waits for the disk, new data is dropped."""
SETUP_SIGNING: int = dialect.MAVLINK_MSG_ID_SETUP_SIGNING


class RunFolder:
    """Writes a run folder during the run.

    Args:
        folder: where to write; created if missing.
        mission: the mission that is flown.
        start_unix_s: wall-clock time of the run's beginning; used only to stamp flight.tlog.
        tell: called with every event that is shown to people.
        keeps_journal: whether to keep a journal, so that a cut-off run can be continued.
        cut_off_at: for the folder of a cut-off run that continues: the number of positions of the
            word that were left. Records of later ones are removed.
        draw: draws flight.png when the folder is closed.

    Attributes:
        journal: the journal of the run.
        trail: the vehicle's positions, by plan, and its charge.
    """

    def __init__(
        self,
        folder: Path,
        mission: Mission,
        start_unix_s: float,
        tell: Callable[[Stamped], None],
        keeps_journal: bool = False,
        cut_off_at: int | None = None,
        draw: Callable[[Mission, Trail, Path], None] = draw_here,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._journal_file = JournalFile(folder) if keeps_journal else None
        self.journal: Journal = self._journal_file or NoJournal()
        self.folder = folder
        self._mission = mission
        self._start_unix_s = start_unix_s
        self._draw = draw
        self._tell = tell
        self.trail = Trail()
        self._is_failing = False
        self._packets = bytearray()
        self._flushed_s = 0.0
        events, tlog = folder / EVENTS_FILE, folder / TLOG_FILE
        about = json.dumps(scene(mission, start_unix_s)) + "\n"
        self._told = ToldWord()
        if cut_off_at is None:
            (folder / MISSION_FILE).write_text(mission.text, encoding="utf-8")
            (folder / SCENE_FILE).write_text(about, encoding="utf-8")
        else:
            write_if_lost(folder / MISSION_FILE, mission.text)
            write_if_lost(folder / SCENE_FILE, about)
            self._told = cut_events(events, cut_off_at)
            cut_tlog(tlog)
        self._disk = DiskThread()
        self._clocks = ClockFile(folder, cut_off_at is not None, self._disk.write)
        mode = "wb" if cut_off_at is None else "ab"
        self._events, self._tlog = events.open(mode), tlog.open(mode)

    @property
    def name(self) -> str:
        """The folder's name; the vehicle's own log is marked with it."""
        return self.folder.name

    def report(self, stamped: Stamped) -> None:
        """Appends a line to events.jsonl; a plan is also written to a file."""
        if stamped.event in self._told:
            return  # the cut-off run has recorded it already
        self.trail.take(stamped)
        if stamped.event.is_told:
            self._tell(stamped)
        self._disk.append(self._events, (json.dumps(line_of(stamped)) + "\n").encode())
        match stamped.event:
            case PlanMade(number=number) | PlanReplaced(number=number) as plan:
                text = json.dumps(json_of(plan), indent=2) + "\n"
                self._disk.write(self.folder / f"plan-{number}.json", text)

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Appends frames to flight.tlog, except those that contain a signing key."""
        stamp_us = int((self._start_unix_s + now_s) * 1e6)
        for datagram in datagrams:
            for frame in split_frames(datagram):
                if message_id(frame) != SETUP_SIGNING:
                    self._packets += bytes(TlogRecord(stamp_us, frame))
        if now_s - self._flushed_s >= FLUSH_S:
            self._flushed_s = now_s
            self._hand_over_packets()
            self._tell_failure()

    def position(self, now_s: float, position: Ned) -> None:
        """Adds a position to the trail of flight.png."""
        self.trail.add(position)

    def clocks(self, reading: ClockReading) -> None:
        """Adds a sample to clocks.json."""
        self._clocks.add(reading)

    def close(self) -> None:
        """Closes the files when everything is written, and draws the flight."""
        if self._journal_file is not None:
            self._journal_file.close()
        self._hand_over_packets()
        self._disk.close()
        self._tell_failure()
        for stream in (self._events, self._tlog):
            with self._going_on():
                stream.close()
        with self._going_on():
            self._draw(self._mission, self.trail, self.folder / "flight.png")

    def _hand_over_packets(self) -> None:
        if self._disk.waiting_bytes < MOST_WAITING_BYTES:
            self._disk.append(self._tlog, bytes(self._packets))
        else:
            self._fail("the disk takes nothing any more")
        self._packets.clear()

    def _tell_failure(self) -> None:
        """Reports in the loop what a thread could not write."""
        journal = self._journal_file
        if failure := self._disk.failure or (journal and journal.failure):
            self._fail(failure)

    @contextmanager
    def _going_on(self) -> Iterator[None]:
        """Keeps errors of the disk from ending the flight."""
        try:
            yield
        except OSError as error:
            self._fail(str(error.strerror))

    def _fail(self, reason: str) -> None:
        """Reports the first failure; later ones are ignored."""
        if not self._is_failing:
            self._is_failing = True
            self._tell(Stamped(0.0, RecordingFailed(reason)))
