"""Models HOAP-3's right arm in numpy, independently of the C sources, from the modified DH table in the manual. Covers
the kinematics, and the gravity torques and inertia matrix of the simulated bodies (a 50 mm cube and rods of 40 mm
diameter)."""

from __future__ import annotations

import numpy as np

STOPS_DEG = np.array([[-91, 151], [-96, 1], [-91, 91], [-115, 1]], float)
MASSES_KG = np.array([0.210, 0.234, 0.1965, 0.216])
GRAVITY = np.array([0.0, 0.0, -9.80665])
PULSES_PER_RAD = 209.0 * 180.0 / np.pi

# Columns: alpha and a of the previous row, d, offset of theta. Rows: from WAIST through CHEST and RARM[0] to joint 4.
MODIFIED_DH = [
    (0.0, -0.035, 0.125, 0.0),
    (-90.0, 0.0, -0.111, 0.0),
    (0.0, 0.0, 0.0, 0.0),
    (90.0, 0.0, 0.0, 90.0),
    (90.0, 0.0, 0.111, 90.0),
    (90.0, 0.0, 0.0, 0.0),
]


def _about(axis: int, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def _shift(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def frames(q: np.ndarray) -> list[np.ndarray]:
    """Returns the four link frames and the end effector frame, in torso axes."""
    angles = [0.0, 0.0, *np.degrees(q)]
    frame, result = np.eye(4), []
    for (alpha, a, d, offset), angle in zip(MODIFIED_DH, angles, strict=True):
        frame = frame @ _about(0, alpha) @ _shift(a, 0, 0) @ _about(2, angle + offset) @ _shift(0, 0, d)
        result.append(frame)
    # The forearm points along y of the last frame. The end effector's z axis points along the forearm; its x axis is
    # that of the last frame.
    hand = frame @ _shift(0, 0.171, 0) @ _about(0, -90.0)
    return [*result[2:], hand]


def centres_of_mass(q: np.ndarray) -> np.ndarray:
    link = frames(q)
    shoulder, elbow, hand = link[0][:3, 3], link[2][:3, 3], link[4][:3, 3]
    upper = elbow - shoulder
    return np.array([shoulder, shoulder + 0.25 * upper, shoulder + 0.75 * upper, 0.5 * (elbow + hand)])


def _rod_inertia(mass: float, length: float, direction: np.ndarray) -> np.ndarray:
    """Returns the inertia of a solid cylinder with 20 mm radius about its centre."""
    along = 0.5 * mass * 0.020**2
    across = mass * (3 * 0.020**2 + length**2) / 12
    return across * np.eye(3) + (along - across) * np.outer(direction, direction)


def inertias(q: np.ndarray) -> list[np.ndarray]:
    link = frames(q)
    shoulder, elbow, hand = link[0][:3, 3], link[2][:3, 3], link[4][:3, 3]
    upper, fore = (elbow - shoulder) / 0.111, (hand - elbow) / 0.171
    cube = MASSES_KG[0] * 0.050**2 / 6 * np.eye(3)
    return [
        cube,
        _rod_inertia(MASSES_KG[1], 0.111 / 2, upper),
        _rod_inertia(MASSES_KG[2], 0.111 / 2, upper),
        _rod_inertia(MASSES_KG[3], 0.171, fore),
    ]


def _velocity_maps(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns two arrays (4 bodies, 3, 4 joints). The first maps joint velocities to the velocities of the bodies'
    centres, the second to the bodies' angular velocities."""
    link, centre = frames(q), centres_of_mass(q)
    linear, angular = np.zeros((4, 3, 4)), np.zeros((4, 3, 4))
    for body in range(4):
        for joint in range(body + 1):
            axis, origin = link[joint][:3, 2], link[joint][:3, 3]
            linear[body, :, joint] = np.cross(axis, centre[body] - origin)
            angular[body, :, joint] = axis
    return linear, angular


def holding_torque(q: np.ndarray) -> np.ndarray:
    """Returns the motor torques that balance gravity at rest."""
    linear, _ = _velocity_maps(q)
    return -np.einsum("b,bkj,k->j", MASSES_KG, linear, GRAVITY)


def inertia_matrix(q: np.ndarray) -> np.ndarray:
    linear, angular = _velocity_maps(q)
    matrix = np.einsum("b,bki,bkj->ij", MASSES_KG, linear, linear)
    for body, inertia in enumerate(inertias(q)):
        matrix += angular[body].T @ inertia @ angular[body]
    return matrix


def random_posture(rng: np.random.Generator, margin_deg: float = 2.0) -> np.ndarray:
    return np.radians(rng.uniform(STOPS_DEG[:, 0] + margin_deg, STOPS_DEG[:, 1] - margin_deg))


def hands(q: np.ndarray) -> np.ndarray:
    """Returns the end effector positions (N, 3) in postures (N, 4)."""
    chain = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for joint, (alpha, a, d, offset) in enumerate(MODIFIED_DH):
        angle = np.radians(offset) + (q[:, joint - 2] if joint >= 2 else np.zeros(len(q)))
        turn = np.broadcast_to(np.eye(4), (len(q), 4, 4)).copy()
        turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
        turn[:, 1, 0], turn[:, 0, 1] = np.sin(angle), -np.sin(angle)
        chain = chain @ (_about(0, alpha) @ _shift(a, 0, 0)) @ turn @ _shift(0, 0, d)
    return (chain @ np.array([0, 0.171, 0, 1]))[:, :3]
