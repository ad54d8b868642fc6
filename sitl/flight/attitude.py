"""Conversions between thrust directions, Euler angles and attitude errors.

Pure functions on quaternions (w, x, y, z), body to NED. The reduced attitude follows Brescianini,
Hehn, D'Andrea, "Nonlinear Quadrocopter Attitude Control" (ETH Zurich, 2013), as PX4's
AttitudeControl does.
"""

from __future__ import annotations

import math

from companion.geometry import Ned, Quaternion


def quaternion_from_euler(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Attitude of roll, pitch, yaw in radians (Tait-Bryan, z-y'-x'')."""
    c_r, s_r = math.cos(roll / 2), math.sin(roll / 2)
    c_p, s_p = math.cos(pitch / 2), math.sin(pitch / 2)
    c_y, s_y = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        c_r * c_p * c_y + s_r * s_p * s_y,
        s_r * c_p * c_y - c_r * s_p * s_y,
        c_r * s_p * c_y + s_r * c_p * s_y,
        c_r * c_p * s_y - s_r * s_p * c_y,
    )


def attitude_from_thrust(thrust: Ned, yaw_rad: float) -> Quaternion:
    """The attitude with a given heading whose -z axis points along a thrust vector.

    Args:
        thrust: NED, any length but zero; its down component is negative.
        yaw_rad: heading of the forward axis, seen from above.
    """
    # The third column of Rz(yaw) Ry(pitch) Rx(roll), turned back by the heading, is
    # (sin pitch cos roll, -sin roll, cos pitch cos roll).
    norm = math.hypot(*thrust)
    north, east, down = (-t / norm for t in thrust)
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    roll = -math.asin(max(-1.0, min(1.0, c * east - s * north)))
    pitch = math.atan2(c * north + s * east, down)
    return quaternion_from_euler(roll, pitch, yaw_rad)


def tilt_and_heading(q: Quaternion, wanted: Quaternion) -> tuple[float, float, float]:
    """The rotation from q to a wanted attitude: x and y turn the thrust axis, z turns about it.

    The error e = q^-1 wanted is split as e = tilt * twist: a rotation about an axis in the rotor
    plane by the shortest way, then one about body z. Each component is 2 sin(angle / 2) times the
    axis, in body coordinates.
    """
    w, x, y, z = q
    w_d, x_d, y_d, z_d = wanted
    e_w = w * w_d + x * x_d + y * y_d + z * z_d
    e_x = w * x_d - x * w_d - y * z_d + z * y_d
    e_y = w * y_d + x * z_d - y * w_d - z * x_d
    e_z = w * z_d - x * y_d + y * x_d - z * w_d
    twist = math.hypot(e_w, e_z)
    if twist < 1e-9:  # the thrust axis points the opposite way: any axis is right
        return (2.0, 0.0, 0.0)
    return (
        2 * (e_x * e_w - e_y * e_z) / twist,
        2 * (e_y * e_w + e_x * e_z) / twist,
        math.copysign(2 * e_z / twist, e_z * e_w),
    )
