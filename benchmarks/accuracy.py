"""FRFs and modes of random robots against sixty digits, from the URDF's numbers on.

Writes docs/tables/accuracy.md. `python benchmarks/accuracy.py [ROBOTS]`, 500 if none are given. Each robot is
a URDF and a card on disk, loaded as any user's; its truth is reckoned from the same numbers by mpmath alone:
transforms multiplied out, M = Σ JᵀMJ, Z solved by elimination, and from each pole that the program gives
Newton's method on (λ²M + λB + K) u = 0, whose start is right if it ends beside it. That no pole is missing is
seen from their sum and product, −tr M⁻¹B and det M⁻¹K.
"""

from __future__ import annotations

import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import mpmath as mp
import numpy as np
from tables import write

import flexmodal
from flexmodal.errors import FlexmodalError, InaccurateModes

ROBOTS = 500
DIGITS = 60
MOST = 30
POLES = 5
"""Poles of each robot that are looked at, its lowest and highest among them."""
LINES = 4
GRAVITY = 9.80665
KINDS = {
    "plain": "revolute, stiffness over two decades, damping ratios near 1 %",
    "sliding": "every other joint prismatic",
    "decades": "stiffness of the joints over twelve decades",
    "light": "links of 1e-9 kg among others",
    "rotors": "rotors up to 10⁴ times their links",
    "undamped": "no damping at all",
    "heavy damping": "damping ratios of 0.1 to 3, joint by joint",
    "hysteresis": "loss factors of 0.001 to 0.1; FRFs only",
}
FRF_GOAL, MODE_GOAL, LIGHT_GOAL = 1e-9, 1e-9, 1e-4
"""Errors above which the script ends with 1: of an FRF; of a pole, per unit of its condition;
and of one of links without mass, whose M has lost the digits already."""


@dataclass
class Made:
    """A random robot, as numbers."""

    axes: list[list[float]]
    offsets: list[list[float]]
    turns: list[list[float]]
    slides: list[bool]
    masses: list[float]
    centres: list[list[float]]
    moments: list[list[float]]
    stiffness: list[float]
    damping: list[float]
    rotors: list[float]
    loss: list[float]
    posture: list[float]


def made(rng: np.random.Generator, kind: str) -> Made:
    """Draw a robot of a kind; links of half a metre, one to some kilograms."""
    n = int(rng.integers(1, MOST + 1))
    axes = rng.normal(size=(n, 3))
    masses = 10 ** rng.uniform(-0.5, 1, n)
    if kind == "light":
        masses[rng.random(n) < 0.4] = 1e-9
        masses[-1] = 1.0
    size = rng.uniform(0.1, 0.4, (n, 3)) ** 2 * masses[:, None]
    moments = np.stack([size[:, 1] + size[:, 2], size[:, 0] + size[:, 2], size[:, 0] + size[:, 1]], axis=1)
    stiffness = 10 ** (rng.uniform(2, 14, n) if kind == "decades" else rng.uniform(3, 5, n))
    ratio = 10 ** rng.uniform(-2.5, -1.5, n)
    if kind == "heavy damping":
        ratio = 10 ** rng.uniform(-1, 0.5, n)
    behind = np.cumsum(masses[::-1])[::-1]
    damping = 2 * ratio * np.sqrt(stiffness * behind * 0.1)
    rotors = moments.max(axis=1) * 10 ** rng.uniform(0, 4, n) if kind == "rotors" else np.zeros(n)
    loss = 10 ** rng.uniform(-3, -1, n) if kind == "hysteresis" else np.zeros(n)
    slides = [bool(kind == "sliding" and i % 2) for i in range(n)]
    return Made(
        (axes / np.linalg.norm(axes, axis=1)[:, None]).tolist(), rng.uniform(-0.4, 0.4, (n, 3)).tolist(),
        rng.uniform(-1.5, 1.5, (n, 3)).tolist(), slides, masses.tolist(),
        rng.uniform(-0.2, 0.2, (n, 3)).tolist(), moments.tolist(), stiffness.tolist(),
        (0 * damping if kind in ("undamped", "hysteresis") else damping).tolist(), rotors.tolist(),
        loss.tolist(), rng.uniform(-1, 1, n).tolist(),
    )  # fmt: skip


def load(robot: Made, folder: Path) -> flexmodal.Robot:
    """Write its files and load them."""

    def words(values: list[float]) -> str:
        return " ".join(repr(value) for value in values)

    parts = ['<robot name="random"><link name="base"/>']
    card = 'format = 1\nname = "random"\ntitle = "r"\nurdf = "r.urdf"\nsource = "drawn"\n'
    card += f'tool = "l{len(robot.axes) - 1}"\n'
    for i, axis in enumerate(robot.axes):
        ixx, iyy, izz = robot.moments[i]
        parts.append(
            f'<link name="l{i}"><inertial><origin xyz="{words(robot.centres[i])}"/><mass '
            f'value="{robot.masses[i]!r}"/>'
            f'<inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{i}" type="{"prismatic" if robot.slides[i] else "revolute"}">'
            f'<parent link="{f"l{i - 1}" if i else "base"}"/><child link="l{i}"/>'
            f'<origin xyz="{words(robot.offsets[i])}" rpy="{words(robot.turns[i])}"/><axis '
            f'xyz="{words(axis)}"/>'
            '<limit lower="-4" upper="4" effort="1" velocity="1"/></joint>'
        )
        card += f"[joint.j{i}]\nstiffness = {robot.stiffness[i]!r}\ndamping = {robot.damping[i]!r}\n"
        card += f"rotor_inertia = {robot.rotors[i]!r}\n" * (robot.rotors[i] > 0)
        card += f"loss_factor = {robot.loss[i]!r}\n" * (robot.loss[i] > 0)
    (folder / "r.urdf").write_text("".join([*parts, "</robot>"]))
    (folder / "robot.toml").write_text(card)
    return flexmodal.load(folder / "robot.toml")


def rotation(axis: list[mp.mpf], angle: mp.mpf) -> mp.matrix:
    """Rodrigues' formula, for an axis that is scaled to unit length first, as a reader of URDFs does."""
    size = mp.sqrt(sum(one * one for one in axis))
    x, y, z = (one / size for one in axis)
    cross = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return mp.eye(3) + mp.sin(angle) * cross + (1 - mp.cos(angle)) * cross * cross


def truth(robot: Made) -> tuple[mp.matrix, mp.matrix]:
    """Mass matrix, and the rows x, y, z of the last link's frame, by multiplying everything out."""
    n = len(robot.axes)
    turn, place = mp.eye(3), mp.matrix(3, 1)
    unit = ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    origins, axes, centres, inertias = [], [], [], []
    for i in range(n):
        roll, pitch, yaw = (mp.mpf(one) for one in robot.turns[i])
        place = place + turn * mp.matrix(robot.offsets[i])
        turn = turn * (rotation(unit[2], yaw) * rotation(unit[1], pitch) * rotation(unit[0], roll))
        axis = [mp.mpf(one) for one in robot.axes[i]]
        size = mp.sqrt(sum(one * one for one in axis))
        axes.append(turn * mp.matrix(axis) / size)
        if robot.slides[i]:
            place = place + axes[-1] * robot.posture[i]
        else:
            turn = turn * rotation(axis, mp.mpf(robot.posture[i]))
        origins.append(place)
        centres.append(place + turn * mp.matrix(robot.centres[i]))
        inertias.append(turn * mp.diag(robot.moments[i]) * turn.T)
    mass = mp.diag(robot.rotors)
    for body in range(n):
        rows = [_column(robot.slides[k], axes[k], origins[k], centres[body]) for k in range(body + 1)]
        for i, (moved, spun) in enumerate(rows):
            pushed, twisted = robot.masses[body] * moved, inertias[body] * spun
            for j in range(i, body + 1):
                value = _dot(pushed, rows[j][0]) + _dot(twisted, rows[j][1])
                mass[i, j] += value
                if i != j:
                    mass[j, i] += value
    tool = [_column(robot.slides[k], axes[k], origins[k], origins[-1])[0] for k in range(n)]
    return mass, mp.matrix([[tool[k][row] for k in range(n)] for row in range(3)])


def _dot(a: mp.matrix, b: mp.matrix) -> mp.mpf:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _column(
    slides: bool, axis: mp.matrix, origin: mp.matrix, point: mp.matrix
) -> tuple[mp.matrix, mp.matrix]:
    if slides:
        return axis, mp.matrix(3, 1)
    a, b = axis, point - origin
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]), axis


def frf_error(
    robot: Made, loaded: flexmodal.Robot, mass: mp.matrix, rows: mp.matrix, axis: list[float]
) -> float:
    """Largest error of the 3 × 3 receptance, relative to its own largest entry at each line."""
    pose = {f"j{i}": value for i, value in enumerate(robot.posture)}
    along = [f"l{len(robot.axes) - 1}:+{name}" for name in "xyz"]
    if len(robot.axes) == 1 and not robot.slides[0]:
        return 0.0  # the frame of the only link does not move
    value = loaded.frf(pose, axis, response=along, reference=along).value
    worst = 0.0
    stiff = mp.diag([mp.mpc(k, mp.mpf(k) * e) for k, e in zip(robot.stiffness, robot.loss, strict=True)])
    for line, frequency in enumerate(axis):
        omega = 2 * mp.pi * mp.mpf(frequency)
        Z = stiff - omega**2 * mass + mp.mpc(0, 1) * omega * mp.diag(robot.damping)
        exact = np.array((rows * _solved(Z, rows.T)).tolist(), dtype=object)
        size = max(abs(one) for one in exact.ravel())
        gaps = [
            abs(mp.mpmathify(complex(a)) - b) for a, b in zip(value[line].ravel(), exact.ravel(), strict=True)
        ]
        worst = max(worst, float(max(gaps) / size))
    return worst


def _solved(Z: mp.matrix, right: mp.matrix) -> mp.matrix:
    found = mp.matrix(right.rows, right.cols)
    factors, order = mp.mp.LU_decomp(Z)
    for column in range(right.cols):
        found[:, column] = mp.mp.U_solve(factors, mp.mp.L_solve(factors, right[:, column], order))
    return found


def pole_errors(
    robot: Made, modes: flexmodal.Modes, mass: mp.matrix, rng: np.random.Generator
) -> tuple[list[tuple[float, float]], float]:
    """Relative error and condition of some poles, and how far sum and product of all are off."""
    n = len(robot.axes)
    stiff, damping = mp.diag(robot.stiffness), mp.diag(robot.damping)
    picked = {0, len(modes.pole) - 1, *rng.integers(0, len(modes.pole), POLES - 2).tolist()}
    found = []
    for place in sorted(picked):
        pole = mp.mpmathify(complex(modes.pole[place]))
        exact = newton(pole, modes.shape[:, place], mass, damping, stiff)
        found.append((float(abs(pole - exact) / abs(exact)), float(modes.condition[place])))
    every, _ = modes.expanded()
    product = sum((mp.log(abs(mp.mpmathify(complex(one)))) for one in every), mp.mpf(0))
    wanted = mp.log(mp.det(stiff)) - mp.log(mp.det(mass))
    return found, float(abs(product - wanted)) if len(every) == 2 * n else float("inf")


def newton(pole: mp.mpc, shape: np.ndarray, mass: mp.matrix, damping: mp.matrix, stiff: mp.matrix) -> mp.mpc:
    """The pole that Newton's method on pole and shape ends at."""
    n = len(shape)
    u = mp.matrix([mp.mpmathify(complex(one)) for one in shape])
    u = u / mp.norm(u)
    border = [mp.conj(one) for one in u]
    for _ in range(30):
        Z = pole**2 * mass + pole * damping + stiff
        left = Z * u
        slope = (2 * pole * mass + damping) * u
        whole, right = mp.matrix(n + 1, n + 1), mp.matrix(n + 1, 1)
        for i in range(n):
            for j in range(n):
                whole[i, j] = Z[i, j]
            whole[i, n], whole[n, i], right[i] = slope[i], border[i], -left[i]
        step = mp.lu_solve(whole, right)
        u, pole = u + step[:n], pole + step[n]
        if abs(step[n]) < mp.mpf(10) ** -20 * abs(pole):  # what is left is its square
            break
    return pole


def one_robot(number: int) -> tuple[str, int, float, list[tuple[float, float]], float, str]:
    """A robot by its number: kind, joints, FRF error, pole errors, completeness, what was refused."""
    mp.mp.dps = DIGITS
    rng = np.random.default_rng([61, number])
    kind = list(KINDS)[number % len(KINDS)]
    robot = made(rng, kind)
    with tempfile.TemporaryDirectory() as name:
        loaded = load(robot, Path(name))
    mass, rows = truth(robot)
    pose = {f"j{i}": value for i, value in enumerate(robot.posture)}
    system = loaded.at(pose).system
    natural = (
        np.sort(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(system.mass, system.stiffness)))))
        / 2
        / np.pi
    )
    low, high = natural[0], natural[-1]
    axis = 10 ** rng.uniform(np.log10(low / 3), np.log10(high * 3), LINES - 1)
    if kind != "undamped":
        axis = np.append(axis, natural[rng.integers(len(natural))])
    axis = np.unique(np.clip(axis, 1e-6, 1e9))
    refused, poles, complete = "", [], 0.0
    try:
        frf = frf_error(robot, loaded, mass, rows, axis.tolist())
    except FlexmodalError as error:
        return kind, len(robot.axes), 0.0, [], 0.0, f"FRF: {error}"
    if kind != "hysteresis":
        try:
            poles, complete = pole_errors(robot, loaded.modes(pose), mass, rng)
        except InaccurateModes:
            refused = "modes"
    return kind, len(robot.axes), frf, poles, complete, refused


def gravity_shift(arm: flexmodal.Robot, pose: dict[str, float]) -> np.ndarray:
    """By which part gravity, left out, would move each natural frequency in a posture, lowest first.

    The term ∂g/∂q of the potential energy's second derivative adds to K; damping is left out.
    """
    import pinocchio as pin

    model = arm.pinocchio.copy()
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    vector = np.array([pose.get(name, 0.0) for name in arm.moving])
    where = pin.integrate(model, pin.neutral(model), vector)
    slope = pin.computeGeneralizedGravityDerivatives(model, model.createData(), where)
    system, pick = arm.at(pose).system, arm.flexible_index
    without, with_it = (
        np.sort(np.linalg.eigvals(np.linalg.solve(system.mass, K)).real)
        for K in (system.stiffness, system.stiffness + slope[np.ix_(pick, pick)])
    )
    return np.sqrt(np.maximum(with_it, 0) / without) - 1


def gravity_rows() -> list[str]:
    """How far gravity, left out, moves the natural frequencies of the arms that ship."""
    found = []
    for arm in flexmodal.robots():
        rng, worst, first = np.random.default_rng(0), 0.0, 0.0
        low = np.maximum([joint.lower for joint in arm.commanded.values()], -np.pi)
        high = np.minimum([joint.upper for joint in arm.commanded.values()], np.pi)
        for _ in range(200):
            pose = dict(zip(arm.commanded, rng.uniform(low, high).tolist(), strict=True))
            shift = np.abs(gravity_shift(arm, pose))
            worst, first = max(worst, float(shift.max())), max(first, float(shift[0]))
        found.append(f"`{arm.name}` {100 * worst:.2g} % ({100 * first:.2g} % of the lowest)")
    return found


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else ROBOTS
    gathered: dict[str, list] = {kind: [] for kind in KINDS}
    with ProcessPoolExecutor(int(os.environ.get("PROCESSES", os.cpu_count() or 1))) as pool:
        for done, found in enumerate(pool.map(one_robot, range(count)), start=1):
            gathered[found[0]].append(found)
            if done % 25 == 0:
                print(f"{done} robots", file=sys.stderr, flush=True)
    rows, failed = [], False
    for kind, words in KINDS.items():
        some = gathered[kind]
        if not some:
            continue
        frf = [one[2] for one in some]
        poles = [pair for one in some for pair in one[3]]
        good = [error for error, condition in poles if condition < 1e4]
        each = max((error / condition for error, condition in poles if np.isfinite(condition)), default=0.0)
        complete = max((one[4] for one in some), default=0.0)
        refused = sum(bool(one[5]) for one in some)
        failed |= (
            max(frf) > FRF_GOAL
            or each > (LIGHT_GOAL if kind == "light" else MODE_GOAL)
            or complete > LIGHT_GOAL
        )
        rows.append([
            f"{kind}: {words}", str(len(some)), f"{max(one[1] for one in some)}", f"{np.median(frf):.1e}",
            f"{max(frf):.1e}", str(len(poles)), f"{max(good, default=0.0):.1e}" if poles else "",
            f"{each:.1e}" if poles else "", f"{complete:.1e}" if poles else "", str(refused),
        ])  # fmt: skip
    header = [
        "kind", "robots", "most joints", "FRF: median", "FRF: worst", "poles", "pole: worst",
        "worst per condition", "product of all", "refused",
    ]  # fmt: skip
    lead = (
        f"`make accuracy`: {count} random robots of 1 to {MOST} joints against {DIGITS} "
        f"digits. FRFs: largest error of "
        "the tool's 3 × 3 receptance at a line, relative to its largest entry; lines from "
        "a third of the lowest to "
        "three times the highest natural frequency, one of them at a resonance where there "
        "is damping. Poles: "
        "relative errors of those with a condition below 10⁴; of all, divided by their "
        "condition; and the logarithm "
        "of the product of all poles against det M⁻¹K, which shows that none is missing. "
        "Refused: robots whose modes "
        "the program says it has no digits of."
    )
    end = (
        "Gravity is left out of every model. Its linearised term ∂g/∂q would add to K; "
        "over 200 random postures each "
        f"it would move a natural frequency by at most: {'; '.join(gravity_rows())}."
    )
    write("accuracy", "FRFs and modes of random robots against sixty digits", lead, header, rows, end=end)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
