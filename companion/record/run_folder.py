"""One folder per run: mission, scene, plans, events.jsonl, flight.tlog, clocks.json, flight.png.

- `events.jsonl`: one event per line with `t_s` (seconds since the run began), `kind`, `text` and
  the fields of the event (docs/run-folder.md). It holds no wall-clock time, so that equal runs
  give equal bytes.
- `scene.json`: what the mission says of the world (scene.py).
- `plan-N.json`: the N-th plan; 0 is the first, N the one after replan N.
- `flight.tlog`: every MAVLink frame in either direction behind eight bytes of time (big-endian
  microseconds since 1970), as MAVProxy and QGroundControl write it. It reaches the disk five times
  a second of the flight's time, so that others can follow it.
- `clocks.json`: what the clocks of the run showed at the same time (clocks.py).
- `journal.jsonl`: what another process needs to go on with the flight (journal_file.py), if asked.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.acting.journal import Journal, NoJournal
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.hosting import RecordingFailed
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.sortie import RunEnded
from companion.flight_events.writing import json_of, line_of
from companion.geometry import Ned
from companion.mavlink.framing import dialect, message_id, split_frames
from companion.mission.model import Mission
from companion.record.clocks import ClockFile
from companion.record.cut_off import ToldWord, cut_events, cut_tlog, write_if_lost
from companion.record.drawing import draw_here
from companion.record.events import EVENTS_FILE, MISSION_FILE, SCENE_FILE, TLOG_FILE
from companion.record.journal_file import JournalFile
from companion.record.scene import scene
from companion.record.trail import Trail
from companion.vehicle.run_clocks import ClockReading

FLUSH_S = 0.2
SETUP_SIGNING: int = dialect.MAVLINK_MSG_ID_SETUP_SIGNING


class RunFolder:
    """Writes a run folder while the run goes on.

    Args:
        folder: where to write; made if missing.
        mission: the mission flown.
        start_unix_s: wall-clock time of the run's beginning; stamps flight.tlog alone.
        tell: called with every event that is news for people.
        keeps_journal: so that the run can be gone on with if it is cut off.
        cut_off_at: it is the folder of a run that was cut off, to go on with: how many positions of
            the word it had left. What was recorded of later ones is left out.
        draw: draws flight.png when it is closed.

    Attributes:
        journal: of the run.
        trail: where the vehicle was, by plan, and its charge.
        has_ended: whether its end was reported.
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
        self.has_ended = False
        self._is_failing = False
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
        self._clocks = ClockFile(folder, is_continued=cut_off_at is not None)
        mode = "w" if cut_off_at is None else "a"
        self._events = events.open(mode, encoding="utf-8")
        self._tlog = tlog.open(f"{mode}b")

    @property
    def name(self) -> str:
        """Of the folder; the vehicle's own log is marked with it."""
        return self.folder.name

    def report(self, stamped: Stamped) -> None:
        """Appends a line to events.jsonl, at once; a plan also becomes a file."""
        if stamped.event in self._told:
            return  # the run that was cut off has told it
        self.has_ended |= isinstance(stamped.event, RunEnded)
        self.trail.take(stamped)
        if stamped.event.is_told:
            self._tell(stamped)
        with self._going_on():
            self._events.write(json.dumps(line_of(stamped)) + "\n")
            self._events.flush()
            match stamped.event:
                case PlanMade(number=number) | PlanReplaced(number=number) as plan:
                    self._plan(number, plan)

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Appends frames to flight.tlog; none with a signing key in it."""
        stamp = struct.pack(">Q", int((self._start_unix_s + now_s) * 1e6))
        with self._going_on():
            for datagram in datagrams:
                for frame in split_frames(datagram):
                    if message_id(frame) != SETUP_SIGNING:
                        self._tlog.write(stamp + frame)
            if self._journal_file is not None and self._journal_file.failure is not None:
                raise OSError(0, self._journal_file.failure)
            if now_s - self._flushed_s >= FLUSH_S:
                self._tlog.flush()
                self._flushed_s = now_s

    def position(self, now_s: float, position: Ned) -> None:
        """Adds to the trail of flight.png."""
        self.trail.add(position)

    def clocks(self, reading: ClockReading) -> None:
        """Adds to clocks.json."""
        with self._going_on():
            self._clocks.add(reading)

    def close(self) -> None:
        """Closes the files and draws the flight."""
        if self._journal_file is not None:
            self._journal_file.close()
        for stream in (self._events, self._tlog):
            with self._going_on():
                stream.close()
        with self._going_on():
            self._draw(self._mission, self.trail, self.folder / "flight.png")

    @contextmanager
    def _going_on(self) -> Iterator[None]:
        """A full disk ends no flight: the first failure is told, later ones are not."""
        try:
            yield
        except OSError as error:
            if not self._is_failing:
                self._is_failing = True
                self._tell(Stamped(0.0, RecordingFailed(str(error.strerror))))

    def _plan(self, number: int, plan: FlightEvent) -> None:
        """Writes a plan."""
        path = self.folder / f"plan-{number}.json"
        path.write_text(json.dumps(json_of(plan), indent=2) + "\n", encoding="utf-8")
