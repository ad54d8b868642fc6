"""A companion that only takes uploads: component 191 on a simulator's link, in a thread.

It beats, answers MAVLink FTP at once, tells verdicts as STATUSTEXT, accepts MISSION_START and
then says that its run has ended. Its link can lose datagrams, either way, by a seed.
"""

from __future__ import annotations

import random
import threading
import time
from pathlib import Path

from companion.ground.upload_states import UploadVerdict
from companion.ground.uploads import Uploads
from companion.ground.watching import EXIT_CODE
from companion.mavlink.framing import MavlinkCodec, Message, dialect, source
from companion.mavlink.statustext import chunks
from companion.vehicle.endpoints import UdpPort
from companion.vehicle.link import Link

COMPANION = 191
MISSION_START = 300


class UploadHost:
    """Use as a context.

    Args:
        port: that the simulator sends to.
        root: of the files.
        loss: probability that a datagram of MAVLink FTP is lost.
        exit_code: of the run that MISSION_START starts.
    """

    def __init__(self, port: int, root: Path, loss: float = 0.0, exit_code: int = 0) -> None:
        self.uploads = Uploads(root)
        self.verdicts: list[UploadVerdict] = []
        self.failure: Exception | None = None
        self._link = Link(UdpPort("127.0.0.1", port))
        self._codec = MavlinkCodec(0, COMPANION)
        self._loss, self._rng = loss, random.Random(1)
        self._exit_code = exit_code
        self._texts = 0
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> UploadHost:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ends.set()
        self._thread.join()
        self._link.close()
        self.uploads.close()
        if self.failure is not None:
            raise self.failure

    def _run(self) -> None:
        try:
            beat_s = 0.0
            while not self._ends.is_set():
                self._link.wait(0.02)
                self._link.send([])  # begins a step: what is taken in of one is bounded
                for datagram in self._link.receive():
                    for message in self._codec.parse(datagram):
                        self._take(message)
                now_s = time.monotonic()
                for verdict in self.uploads.poll(now_s):
                    self.verdicts.append(verdict)
                    self._say(verdict.text)
                if now_s > beat_s + 1.0:
                    beat_s = now_s
                    self._send(dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))
        except Exception as error:
            self.failure = error

    def _take(self, message: Message) -> None:
        system, component = source(message)
        if component == 1:
            self._codec.system = system
        if getattr(message, "target_component", 0) != COMPANION:
            return
        if message.get_type() == "FILE_TRANSFER_PROTOCOL" and not self._is_lost():
            client, payload = source(message), bytes(message.payload)
            for reply in self.uploads.ftp(time.monotonic(), client, payload):
                if not self._is_lost():
                    kind = dialect.MAVLink_file_transfer_protocol_message
                    self._send(kind(0, *client, list(reply)))
        if message.get_type() == "COMMAND_LONG":
            is_start = message.command == MISSION_START
            result = 0 if is_start else dialect.MAV_RESULT_UNSUPPORTED
            self._send(
                dialect.MAVLink_command_ack_message(message.command, result, 0, 0, *source(message))
            )
            if is_start:
                self.start()

    def start(self) -> None:
        """The run starts, and ends with its exit code."""
        self._say("the run has started, and has ended at once, which is a long text")
        self._send(dialect.MAVLink_named_value_int_message(0, EXIT_CODE.encode(), self._exit_code))

    def _is_lost(self) -> bool:
        return self._rng.random() < self._loss

    def _say(self, text: str) -> None:
        self._texts += 1
        for message in chunks(6, text, self._texts):
            self._send(message)

    def _send(self, message: Message) -> None:
        if self._codec.system:
            self._link.send([self._codec.pack(message)])
