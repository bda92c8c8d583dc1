"""Chains to test with, and a model of them on paper: complex numbers, transforms multiplied out, Σ JᵀMJ."""

from dataclasses import dataclass

import numpy as np

import flexmodal


@dataclass
class Link:
    kind: str
    axis: np.ndarray
    offset: np.ndarray
    roll: np.ndarray
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    stiffness: float
    damping: float


def random_links(rng, count, *, planar=False, slides=()):
    links = []
    for i in range(count):
        axis = np.array([0.0, 0.0, 1.0 if i % 3 else -1.0]) if planar else rng.normal(size=3)
        kind = "prismatic" if i in slides else "revolute"
        if planar and kind == "prismatic":
            axis = np.array([0.6, 0.8, 0.0])
        A = 0.1 * rng.normal(size=(3, 3))
        spread = A @ A.T + 0.005 * np.eye(3)  # second moments of the mass: any such body exists
        links.append(
            Link(
                kind,
                axis / np.linalg.norm(axis),
                np.array([0.4, 0.05, 0.01]) if i else np.zeros(3),
                np.array([0.0, 0.0, 0.2]) if planar else rng.uniform(-1, 1, 3),
                float(rng.uniform(1, 5)),
                np.array([0.2, 0.03, 0.02]),
                np.trace(spread) * np.eye(3) - spread,
                float(10 ** rng.uniform(3, 5)),
                float(10 ** rng.uniform(0, 2)),
            )
        )
    return links


def write_urdf(links, path):
    text = ['<robot name="chain"><link name="base"/>']
    for i, link in enumerate(links):
        inertia = link.inertia
        entries = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        moments = " ".join(f'{name}="{float(inertia[place])!r}"' for name, place in entries.items())
        text.append(
            f'<link name="l{i}"><inertial><origin xyz="{_words(link.centre)}"/><mass value="{link.mass!r}"/>'
            f"<inertia {moments}/></inertial></link>"
            f'<joint name="j{i}" type="{link.kind}"><parent link="{f"l{i - 1}" if i else "base"}"/>'
            f'<child link="l{i}"/><origin xyz="{_words(link.offset)}" rpy="{_words(link.roll)}"/>'
            f'<axis xyz="{_words(link.axis)}"/><limit lower="-4" upper="4" effort="1" velocity="1"/></joint>'
        )
    path.write_text("".join([*text, "</robot>"]))
    return path


def load(links, path):
    return flexmodal.load(
        write_urdf(links, path),
        stiffness={f"j{i}": link.stiffness for i, link in enumerate(links)},
        damping={f"j{i}": link.damping for i, link in enumerate(links)},
    )


def _words(vector):
    return " ".join(repr(float(value)) for value in vector)


def turned(axis, angle):
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def roll_pitch_yaw(angles):
    r, p, y = angles
    ex, ey, ez = np.eye(3)
    return turned(ez, y) @ turned(ey, p) @ turned(ex, r)


def cross(a, b):
    """np.cross without conjugates or casts: complex steps pass through."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def on_paper(links, q, selectors, omega, *, stiffness=None, damping=None, extra_mass=None, moved=None):
    """Receptance between two directions at the last link's origin, everything complex if anything is.

    `moved` shifts joint axes in the world, bodies staying: joint → vector.
    """
    count = len(links)
    R, p = np.eye(3), np.zeros(3)
    axes, origins, centres, inertias = [], [], [], []
    for i, link in enumerate(links):
        p = p + R @ link.offset
        R = R @ roll_pitch_yaw(link.roll)
        axes.append(R @ link.axis)
        if link.kind == "revolute":
            R = R @ turned(link.axis, q[i])
        else:
            p = p + axes[-1] * q[i]
        origins.append(p)
        centres.append(p + R @ link.centre)
        inertias.append(R @ link.inertia @ R.T)
    joints = [origin + (moved or {}).get(i, 0) for i, origin in enumerate(origins)]

    def columns(point, carrier):
        jacobian = np.zeros((6, count), dtype=complex)
        for i in range(carrier + 1):
            if links[i].kind == "revolute":
                jacobian[:3, i], jacobian[3:, i] = cross(axes[i], point - joints[i]), axes[i]
            else:
                jacobian[:3, i] = axes[i]
        return jacobian

    D = np.zeros((count, count), dtype=complex)
    for i, link in enumerate(links):
        J = columns(centres[i], i)
        D += (link.mass + (extra_mass or {}).get(i, 0)) * J[:3].T @ J[:3] + J[3:].T @ inertias[i] @ J[3:]
    K = np.diag([link.stiffness for link in links]) + (0 if stiffness is None else stiffness)
    B = np.diag([link.damping for link in links]) + (0 if damping is None else damping)
    # A complex frequency steps both parts: solve the real form, so that no imaginary unit is shared.
    re, im = K - omega**2 * D, omega * B
    block = np.block([[re, -im], [im, re]])
    rows = np.asarray(selectors) @ columns(origins[-1], count - 1)
    solved = np.linalg.solve(block, np.concatenate([rows[1], np.zeros(count)]))
    return rows[0] @ solved[:count], rows[0] @ solved[count:]
