"""The flight dynamics of the vehicle by JSBSim, with the autopilot's rate loop.

In: body rates and a thrust for the rate loop, or four motor commands; wind, a seed. Out: the
`FlightState`, read on demand. All physics is in `quadrotor.xml`. The rate loop, which runs as fast
as the physics, is in `rate_control.xml`. This module only loads them, binds their properties and
converts feet to metres. Equal arguments and commands give bit-identical states, also beside other
instances and in another process.

The position is that of the centre of mass, minus its height when the vehicle stands: standing on
flat ground at home is (0, 0, 0). North and east come from JSBSim's own tangent plane, height from
the ground below (plane and ellipsoid differ by 8 cm at 1 km).

The ground is flat, and as high as the world says: a roof is ground to a vehicle above it, both for
the legs and for ground effect.

Left out: walls (the world checks collisions by its distance field), sensor noise, damage. The
vehicle touches the ground only with its legs.

Source: JSBSim reference manual; order of models in FGFDMExec.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib import resources
from typing import NamedTuple

import jsbsim

from companion.geometry import GlobalOrigin, Ned, Quaternion, wrap_angle
from sitl.flight.attitude import quaternion_from_euler
from sitl.flight.battery import NEW, Battery, BatterySpec
from sitl.flight.gusts import Gusts
from sitl.flight.rotors import MASS_KG, Motors

M_PER_FT = 0.3048
LEG_M = 0.12
LEG_SPRING_N_PER_M = 4 * 1500.0
GUST_STEPS = 5  # gusts change at 50 Hz: they are filtered noise of a few hertz at most
STANDING_M = LEG_M - MASS_KG * 9.81 / LEG_SPRING_N_PER_M
"""Height of the centre of mass above the ground at rest: the legs are compressed by 2.5 mm."""

# FGPropagate's numbers for integrators. In the air: Adams-Bashforth 2 for rates and 3 for position
# and attitude; the default (Euler) turns a free spin by 32 degrees in 5 s. On the legs: Euler for
# the rates, because JSBSim's friction stops a contact within one Euler step. Adams-Bashforth would
# only reverse it: the vehicle would tremble by 0.2 m/s^2 after a landing.
_EULER, _ADAMS_BASHFORTH_2, _ADAMS_BASHFORTH_3 = 1, 3, 4


class FlightState(NamedTuple):
    """The true state of the vehicle at one instant.

    Attributes:
        time_s: since the start of the simulation.
        position: local NED, metres; zero when it stands on the ground at home.
        velocity: NED, metres per second.
        attitude: body (forward, right, down) to NED.
        euler: the same as roll, pitch and yaw (Tait-Bryan, z-y'-x''), radians.
        rates: body rates p, q, r relative to NED, rad/s.
        specific_force: body, m/s^2: what an accelerometer measures, -9.8 on z at rest.
        motors: motor commands, in PX4's quad-x order.
        motor_speed_radps: in the same order.
        voltage_v: at the battery's terminals.
        current_a: out of the battery, negative into it.
        charge: remaining, 0 to 1.
        is_on_ground: a leg touches.
    """

    time_s: float
    position: Ned
    velocity: Ned
    attitude: Quaternion
    euler: tuple[float, float, float]
    rates: tuple[float, float, float]
    specific_force: tuple[float, float, float]
    motors: Motors
    motor_speed_radps: tuple[float, float, float, float]
    voltage_v: float
    current_a: float
    charge: float
    is_on_ground: bool


class RateSetpoint(NamedTuple):
    """The setpoint of the rate loop.

    Attributes:
        thrust_n: the thrust of all rotors, along -z of the body.
        rates: desired body rates p, q, r, rad/s.
    """

    thrust_n: float
    rates: tuple[float, float, float]


class Physics:
    """One vehicle in the air above level ground.

    Args:
        dt_s: length of a step.
        origin: where local NED (0, 0, 0) lies; its altitude is that of the ground.
        start: local NED; (n, e, 0) stands on the ground.
        yaw_rad: heading at the start.
        battery: the pack at the start.
        wind: the air's velocity over the ground, NED, m/s.
        linear_drag_n_per_mps: drag of the body in proportion to its airspeed, in addition to that
            of the rotors and the drag in proportion to the square.
        turbulence_mps: standard deviation of the vertical gusts near the ground; horizontal ones
            are about twice as strong (`gusts.py`). Gusts need air that moves past the vehicle: in
            still air, a hovering vehicle meets none.
        seed: the seed of the turbulence, any integer.

    Attributes:
        battery: the pack on board.
    """

    def __init__(
        self,
        *,
        dt_s: float = 0.004,
        origin: GlobalOrigin,
        start: Ned = (0.0, 0.0, 0.0),
        yaw_rad: float = 0.0,
        battery: BatterySpec = NEW,
        wind: Ned = (0.0, 0.0, 0.0),
        linear_drag_n_per_mps: float = 0.0,
        turbulence_mps: float = 0.0,
        seed: int = 0,
    ) -> None:
        self._fdm = _load(dt_s)
        self._start = start
        self._ground_m, self._ground_up_m = origin.altitude_m, 0.0
        self._dt_s = dt_s
        self._steps = 0
        self._set_initial_conditions(origin, start, yaw_rad)
        self.battery = Battery(self._fdm, battery)
        self._fdm["body/linear-drag-n_mps"] = linear_drag_n_per_mps
        if not self._fdm.run_ic():
            raise RuntimeError("JSBSim refuses the initial conditions")
        self._gusts = Gusts(turbulence_mps, seed) if turbulence_mps > 0 else None
        self.set_wind(wind)  # after run_ic, which replaces the wind by its own
        self._bind()
        self.battery.is_draining = False
        self._state: FlightState | None = None
        self._is_on_ground = False
        self._choose_rate_integrators()

    @property
    def state(self) -> FlightState:
        """The state after the last step."""
        if self._state is None:
            self._state = self._read()
        return self._state

    def follow(self, command: RateSetpoint | Motors) -> None:
        """Sets what drives the motors from the next step on: the rate loop, or motor commands.

        After motor commands, the rate loop starts with its integrals at zero.
        """
        if isinstance(command, RateSetpoint):
            self._set_closed(1.0)
            self._set_thrust(command.thrust_n)
            wanted: tuple[float, ...] = command.rates
            setters = self._set_rates
        else:
            self._set_closed(0.0)
            wanted, setters = command, self._set_motors
        for set_value, value in zip(setters, wanted, strict=True):
            set_value(value)

    def step(self) -> None:
        """Advances by one step."""
        if self._gusts is not None and self._steps % GUST_STEPS == 0:
            self._gust(self._gusts)
        self._fdm.run()
        self._steps += 1
        self._state = None
        self._choose_rate_integrators()

    def set_wind(self, wind: Ned) -> None:
        """Sets the mean air velocity over the ground, NED, m/s."""
        self._wind = wind
        for axis, speed in zip(("north", "east", "down"), wind, strict=True):
            self._fdm[f"atmosphere/wind-{axis}-fps"] = speed / M_PER_FT

    @property
    def ground_up_m(self) -> float:
        """Height of the ground below the vehicle, above the ground at home."""
        return self._ground_up_m

    @ground_up_m.setter
    def ground_up_m(self, up_m: float) -> None:
        self._ground_up_m = up_m
        self._set_ground((self._ground_m + up_m) / M_PER_FT)

    def _set_initial_conditions(self, origin: GlobalOrigin, start: Ned, yaw_rad: float) -> None:
        latitude_deg, longitude_deg, _ = origin.to_global(start)
        self._fdm["ic/lat-geod-deg"] = latitude_deg
        self._fdm["ic/long-gc-deg"] = longitude_deg
        self._fdm["ic/terrain-elevation-ft"] = origin.altitude_m / M_PER_FT
        self._fdm["ic/h-agl-ft"] = (STANDING_M - start[2]) / M_PER_FT
        self._fdm["ic/psi-true-rad"] = yaw_rad

    def _gust(self, gusts: Gusts) -> None:
        """Sets the air velocity of the next steps."""
        wind = self._wind
        airspeed_mps = math.dist([speed() * M_PER_FT for speed in self._velocity], wind)
        dt_s = GUST_STEPS * self._dt_s
        gust = gusts.step(self._height() * M_PER_FT, airspeed_mps, wind, dt_s)
        for set_gust, speed in zip(self._set_gusts, gust, strict=True):
            set_gust(speed / M_PER_FT)

    def _bind(self) -> None:
        """Looks the properties up once: reading a bound node takes 40 ns, reading by name 65 to
        290.
        """

        def readers(*names: str) -> tuple[Callable[[], float], ...]:
            return tuple(self._node(name).get_double_value for name in names)

        def writers(*names: str) -> tuple[Callable[[float], bool], ...]:
            return tuple(self._node(name).set_double_value for name in names)

        self._set_closed, self._set_thrust = writers("control/is-closed", "control/wanted-thrust-n")
        self._set_rates = writers(*(f"control/wanted-{i}-radps" for i in "pqr"))
        self._set_motors = writers(*(f"control/given-command-{i}" for i in range(1, 5)))
        self._set_gusts = writers(
            *(f"atmosphere/gust-{axis}-fps" for axis in ("north", "east", "down"))
        )
        (self._set_ground,) = writers("position/terrain-elevation-asl-ft")
        self._set_rate_integrators = writers(
            *(f"simulation/integrator/rate/{i}" for i in ("rotational", "translational"))
        )
        self._charge, self._voltage, self._current, self._wow = readers(
            "battery/charge", "battery/voltage-v", "battery/current-a", "gear/wow"
        )
        self._north, self._east, self._height = readers(
            "position/from-start-neu-n-ft", "position/from-start-neu-e-ft", "position/h-agl-ft"
        )
        self._velocity = readers(*(f"velocities/v-{i}-fps" for i in ("north", "east", "down")))
        self._euler = readers(*(f"attitude/{i}-rad" for i in ("phi", "theta", "psi")))
        self._rates = readers(*(f"velocities/{i}-rad_sec" for i in "pqr"))
        self._specific_force = readers(*(f"accelerations/a-pilot-{i}-ft_sec2" for i in "xyz"))
        self._motors = readers(*(f"rotor/command-{i}" for i in range(1, 5)))
        self._motor_speeds = readers(*(f"rotor/speed-{i}-radps" for i in range(1, 5)))

    def _choose_rate_integrators(self) -> None:
        is_on_ground = self._wow() > 0
        if is_on_ground == self._is_on_ground and self._steps:
            return
        self._is_on_ground = is_on_ground
        order = _EULER if is_on_ground else _ADAMS_BASHFORTH_2
        for set_integrator in self._set_rate_integrators:
            set_integrator(order)

    def _node(self, name: str) -> jsbsim.FGPropertyNode:
        node = self._fdm.get_property_manager().get_node(name)
        if node is None:
            raise RuntimeError(f"JSBSim has no property {name}")
        return node

    def _read(self) -> FlightState:
        v_n, v_e, v_d = self._velocity
        p, q, r = self._rates
        f_x, f_y, f_z = self._specific_force
        c_1, c_2, c_3, c_4 = self._motors
        m_1, m_2, m_3, m_4 = self._motor_speeds
        phi, theta, psi = self._euler
        euler = (phi(), theta(), wrap_angle(psi()))
        return FlightState(
            self._steps * self._dt_s,
            (
                self._start[0] + self._north() * M_PER_FT,
                self._start[1] + self._east() * M_PER_FT,
                STANDING_M - self._height() * M_PER_FT - self._ground_up_m,
            ),
            (v_n() * M_PER_FT, v_e() * M_PER_FT, v_d() * M_PER_FT),
            quaternion_from_euler(*euler),
            euler,
            (p(), q(), r()),
            (f_x() * M_PER_FT, f_y() * M_PER_FT, f_z() * M_PER_FT),
            (c_1(), c_2(), c_3(), c_4()),
            (m_1(), m_2(), m_3(), m_4()),
            self._voltage(),
            self._current(),
            self._charge(),
            self._is_on_ground,
        )


def _load(dt_s: float) -> jsbsim.FGFDMExec:
    """A silent JSBSim with the airframe. The step is set first, because filters read it at load."""
    # Process-wide, and enough for silence. An own logger would belong to a thread, and aborts the
    # interpreter when that thread ends (jsbsim 1.3.3).
    jsbsim.FGJSBBase().debug_lvl = 0  # type: ignore[no-untyped-call]
    with resources.as_file(resources.files(__package__).joinpath("quadrotor.xml")) as airframe:
        fdm = jsbsim.FGFDMExec(str(airframe.parent))
        fdm.set_dt(dt_s)
        fdm.set_aircraft_path(str(airframe.parent))
        if not fdm.load_model(airframe.stem, False):
            raise RuntimeError(f"JSBSim cannot load {airframe}")
    for axis in ("rotational", "translational"):
        fdm[f"simulation/integrator/position/{axis}"] = _ADAMS_BASHFORTH_3
    return fdm
