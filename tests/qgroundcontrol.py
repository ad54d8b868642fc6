"""A client that does what QGroundControl does, with its time limits and its complaints.

Each step fails where QGroundControl would show a popup, a warning or "not ready". Written from
what QGroundControl asks for and how long it waits (its Vehicle, InitialConnectStateMachine,
ParameterManager, PlanManager, PX4FirmwarePlugin and AutoPilotPlugins, spring 2026).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from wire import NAN, Wire, gcs_heartbeat

from companion.mavlink.framing import dialect
from companion.mavlink.parameters import INT32, decode
from companion.mavlink.px4_modes import MODES, mode_name
from sitl.link.routing import LinkName
from sitl.world.scenario import Scenario

ACK_S, ACK_TRIES = 1.2, 3
MESSAGE_S = 1.0
LIST_S = 5.0
ITEM_S, PLAN_ACK_S = 0.25, 1.5
MODE_S = 1.3
ARMED_S = 1.5
COMM_LOST_S = 3.5

READ_BY_PANELS = (
    *(f"COM_FLTMODE{i}" for i in range(1, 7)),
    *("RC_MAP_FLTMODE", "NAV_DLL_ACT", "NAV_RCL_ACT", "COM_LOW_BAT_ACT", "COM_RC_LOSS_T"),
    *("RTL_RETURN_ALT", "RTL_DESCEND_ALT", "RTL_LAND_DELAY", "COM_DISARM_LAND"),
    *("LND_FLIGHT_T_HI", "LND_FLIGHT_T_LO", "MPC_XY_VEL_MAX", "MAV_SYS_ID", "SENS_BOARD_ROT"),
    *("MC_AIRMODE", "THR_MDL_FAC", "BAT_LOW_THR", "BAT_CRIT_THR", "BAT_EMERGEN_THR", "GF_ACTION"),
    *("GF_MAX_HOR_DIST", "GF_MAX_VER_DIST", "MIS_TAKEOFF_ALT", "COM_DL_LOSS_T", "MPC_LAND_SPEED"),
)
"""Parameters without which a setup panel shows "missing parameters"."""


class Popup(AssertionError):
    """What QGroundControl would show."""


class QGroundControl:
    """System 255, component 190, on the ground station's link."""

    def __init__(self, scenario: Scenario | None = None) -> None:
        self.wire = Wire(scenario, link=LinkName.GCS, address=(255, 190))
        self.parameters: dict[str, float] = {}
        self._heartbeat_s = -math.inf

    # Time and messages.

    def run(self, seconds: float) -> None:
        """Let time pass; a heartbeat each second."""
        end_s = self.wire.now_s + seconds
        while self.wire.now_s < end_s - 1e-9:
            if self.wire.now_s - self._heartbeat_s >= 1.0:
                self._heartbeat_s = self.wire.now_s
                self.wire.send(gcs_heartbeat())
            self.wire.run(0.02)

    def wait(self, name: str, since: int, limit_s: float) -> Any | None:
        """The first message of a name that came after a mark."""
        end_s = self.wire.now_s + limit_s
        while True:
            for heard in self.wire.heard[since:]:
                if heard.link is self.wire.link and heard.name == name:
                    return heard.message
            if self.wire.now_s >= end_s:
                return None
            self.run(0.02)

    @property
    def mark(self) -> int:
        return len(self.wire.heard)

    def command(self, number: int, *parameters: float, component: int = 1) -> int:
        """A COMMAND_LONG with QGroundControl's repeats; the result of its answer."""
        filled = (*parameters, *(0.0,) * (7 - len(parameters)))
        since = self.mark
        for confirmation in range(ACK_TRIES):
            self.wire.send(
                dialect.MAVLink_command_long_message(1, component, number, confirmation, *filled)
            )
            ack = self.wait("COMMAND_ACK", since, ACK_S)
            while ack is not None and ack.command != number:
                since += 1
                ack = self.wait("COMMAND_ACK", since, ACK_S)
            if ack is not None:
                return int(ack.result)
        raise Popup(f"vehicle did not respond to command {number}")

    def accepted(self, number: int, *parameters: float) -> None:
        """A command whose refusal is a popup."""
        if result := self.command(number, *parameters):
            raise Popup(f"command {number} denied: {result}")

    # Connecting.

    def connect(self) -> None:
        """All steps of the first connection."""
        if self.wait("HEARTBEAT", 0, COMM_LOST_S) is None:
            raise Popup("no vehicle")
        self._ask_version()
        self.command(dialect.MAV_CMD_REQUEST_MESSAGE, 435.0, 1.0)  # AVAILABLE_MODES: may be denied
        self.command(dialect.MAV_CMD_REQUEST_MESSAGE, 397.0)  # COMPONENT_METADATA: likewise
        self._load_parameters()
        for kind in (0, 1, 2):
            self.load_plan(kind)
        self.run(3.0)

    def _ask_version(self) -> None:
        since = self.mark
        self.accepted(dialect.MAV_CMD_REQUEST_MESSAGE, 148.0)
        version = self.wait("AUTOPILOT_VERSION", since, MESSAGE_S)
        if version is None:
            raise Popup("no AUTOPILOT_VERSION")
        if version.flight_sw_version >> 8 < 0x010401:
            raise Popup("QGroundControl supports PX4 v1.4.1 and above")
        wanted = 4 | 16384 | 32768  # MISSION_INT, MISSION_FENCE, MISSION_RALLY
        assert version.capabilities & wanted == wanted

    def _load_parameters(self) -> None:
        since = self.mark
        self.wire.send(dialect.MAVLink_param_request_read_message(1, 1, b"_HASH_CHECK", -1))
        hashed = self.wait("PARAM_VALUE", since, MESSAGE_S)
        assert hashed is not None and hashed.param_id == "_HASH_CHECK"
        since = self.mark
        self.wire.send(dialect.MAVLink_param_request_list_message(1, 0))
        self.run(LIST_S)
        told = [h.message for h in self.wire.heard[since:] if h.name == "PARAM_VALUE"]
        by_index = {m.param_index: m for m in told if m.param_id != "_HASH_CHECK"}
        if set(by_index) != set(range(told[0].param_count)):
            raise Popup("unable to retrieve the full set of parameters")
        for message in by_index.values():
            value = decode(message.param_value, message.param_type)
            self.parameters[message.param_id] = float(value)

    def reread(self, index: int) -> Any | None:
        """A gap in the list is read by its index."""
        since = self.mark
        self.wire.send(dialect.MAVLink_param_request_read_message(1, 1, b"", index))
        return self.wait("PARAM_VALUE", since, MESSAGE_S)

    def load_plan(self, kind: int) -> list[Any]:
        """Mission (0), geofence (1) or rally points (2)."""
        since = self.mark
        self.wire.send(dialect.MAVLink_mission_request_list_message(1, 1, kind))
        count = self.wait("MISSION_COUNT", since, PLAN_ACK_S)
        if count is None or count.mission_type != kind:
            raise Popup("Mission transfer failed")
        items = []
        for number in range(count.count):
            since = self.mark
            self.wire.send(dialect.MAVLink_mission_request_int_message(1, 1, number, kind))
            item = self.wait("MISSION_ITEM_INT", since, ITEM_S)
            if item is None or item.seq != number:
                raise Popup("Mission transfer failed")
            items.append(item)
        self.wire.send(dialect.MAVLink_mission_ack_message(1, 1, 0, kind))
        return items

    def save_plan(self, kind: int, items: Sequence[tuple[int, int, tuple[float, ...]]]) -> None:
        """Upload items of (command, frame, seven parameters with degrees)."""
        since = self.mark
        self.wire.send(dialect.MAVLink_mission_count_message(1, 1, len(items), kind))
        while True:
            asked = self.wait("MISSION_REQUEST_INT", since, ITEM_S)
            acknowledged = self.wait("MISSION_ACK", since, 0.0)
            if acknowledged is not None:
                if acknowledged.type != 0:
                    raise Popup(f"Mission transfer failed: {acknowledged.type}")
                return
            if asked is None:
                raise Popup("Mission transfer failed: no request")
            command, frame, (a, b, c, d, x, y, z) = items[asked.seq]
            since = self.mark
            self.wire.send(
                dialect.MAVLink_mission_item_int_message(
                    1, 1, asked.seq, frame, command, int(asked.seq == 0), 1,
                    a, b, c, d, round(x * 1e7), round(y * 1e7), z, kind,
                )
            )  # fmt: skip

    # Looking.

    def complaints(self) -> list[str]:
        """What the setup page, the status line and the panels would complain about."""
        found = [
            f"missing parameter {name}" for name in READ_BY_PANELS if name not in self.parameters
        ]
        p = self.parameters
        ready = {
            "airframe": p["SYS_AUTOSTART"] != 0,
            "gyroscope": p["CAL_GYRO0_ID"] != 0,
            "accelerometer": p["CAL_ACC0_ID"] != 0,
            "compass": p["CAL_MAG0_ID"] != 0 or p["SYS_HAS_MAG"] == 0,
            "radio": p["COM_RC_IN_MODE"] == 1 or p["RC_MAP_ROLL"] != 0,
            "battery": p["BAT1_SOURCE"] == -1
            or (p["BAT1_V_CHARGED"] != 0 and p["BAT1_N_CELLS"] != 0),
            "not in the loop": p["SYS_HITL"] == 0,
        }
        found += [
            f"{name} requires setup prior to flight"
            for name, is_ready in ready.items()
            if not is_ready
        ]
        status = self.wire.last("SYS_STATUS")
        if status.onboard_control_sensors_enabled & ~status.onboard_control_sensors_health:
            found.append("Not Ready")
        if self.wire.last("GPS_RAW_INT").fix_type < 3:
            found.append("no GPS lock")
        for name in (
            "EXTENDED_SYS_STATE",
            "HOME_POSITION",
            "BATTERY_STATUS",
            "ALTITUDE",
            "ATTITUDE",
        ):
            if not self.wire.named(name):
                found.append(f"no {name}")
        return found

    def lost_messages(self) -> int:
        """Gaps in the sequence numbers of each component: the link's loss."""
        last: dict[tuple[int, int], int] = {}
        lost = 0
        for heard in self.wire.heard:
            if heard.link is self.wire.link:
                key = (heard.message.get_srcSystem(), heard.message.get_srcComponent())
                number = heard.message.get_seq()
                if key in last:
                    lost += (number - last[key] - 1) % 256
                last[key] = number
        return lost

    # Flying.

    def set_mode(self, name: str) -> None:
        """SET_MODE as a message; the answer is the heartbeat."""
        main, sub = MODES[name]
        since = self.mark
        for _ in range(3):
            armed = self.wire.last("HEARTBEAT").base_mode & 0x80
            self.wire.send(dialect.MAVLink_set_mode_message(1, 1 | armed, main << 16 | sub << 24))
            end_s = self.wire.now_s + MODE_S
            while self.wire.now_s < end_s:
                self.run(0.1)
                for heard in self.wire.heard[since:]:
                    if heard.name == "HEARTBEAT" and mode_name(heard.message.custom_mode) == name:
                        return
        raise Popup(f"Vehicle not changing to {name} flight mode")

    def arm(self) -> None:
        self.accepted(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        end_s = self.wire.now_s + ARMED_S
        while not self.wire.last("HEARTBEAT").base_mode & 0x80:
            if self.wire.now_s > end_s:
                raise Popup("Vehicle rejected arming")
            self.run(0.02)

    def take_off(self, height_m: float) -> None:
        """The guided take-off: the altitude is above the sea, and arming follows."""
        above_sea = self.wire.last("HOME_POSITION").altitude / 1e3 + height_m
        self.accepted(dialect.MAV_CMD_NAV_TAKEOFF, -1.0, 0.0, 0.0, NAN, NAN, NAN, above_sea)
        self.arm()

    def pause(self) -> None:
        self.accepted(dialect.MAV_CMD_DO_REPOSITION, -1.0, 1.0, 0.0, NAN, NAN, NAN, NAN)

    def go_to(self, latitude_deg: float, longitude_deg: float, above_sea_m: float) -> None:
        since = self.mark
        self.wire.send(
            dialect.MAVLink_command_int_message(
                1, 1, 0, dialect.MAV_CMD_DO_REPOSITION, 0, 0, -1.0, 1.0, 0.0, NAN,
                round(latitude_deg * 1e7), round(longitude_deg * 1e7), above_sea_m,
            )
        )  # fmt: skip
        ack = self.wait("COMMAND_ACK", since, ACK_S)
        if ack is None or ack.result:
            raise Popup("Unable to go to the position")

    def set_parameter(self, name: str, value: float, param_type: int) -> None:
        layout = "<i" if param_type == INT32 else "<f"
        number = int(value) if param_type == INT32 else value
        (raw,) = struct.unpack("<f", struct.pack(layout, number))
        since = self.mark
        self.wire.send(dialect.MAVLink_param_set_message(1, 1, name.encode(), raw, param_type))
        told = self.wait("PARAM_VALUE", since, ACK_S)
        if told is None or decode(told.param_value, told.param_type) != value:
            raise Popup(f"parameter write failed: {name}")
