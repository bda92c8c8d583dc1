"""The regenerative cut stepped through time: every tooth, every chip, and teeth that leave the cut.

Written to check the rest, and to show what happens beyond the limit. It shares neither the directional
matrices nor their Fourier series with them: force and chip thickness are those of single teeth at single
instants.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.tip import ModelTip

_SLICES = 12
"""Slices along a helix."""
_CORRECTIONS = 2


@dataclass(frozen=True, eq=False)
class CutHistory:
    """A simulated cut."""

    time: Float[np.ndarray, " step"]
    """[s]."""
    displacement: Float[np.ndarray, "step 3"]
    """Of the tip, along x, y, z of the cut [m]."""
    force: Float[np.ndarray, "step 3"]
    """On the tip [N]."""
    steps: int
    """Steps in a tooth period."""

    def growth(self, periods: int = 20) -> float:
        """Factor by which the vibration grows in a tooth period, fitted over the last so many periods.

        Of a simulation without feed this is the size of the largest Floquet multiplier.
        """
        tail = self.displacement[-periods * self.steps :].reshape(periods, -1)
        size = np.log(np.linalg.norm(tail, axis=1))
        return float(np.exp(np.polyfit(np.arange(periods), size, 1)[0]))


def simulate(
    tip: ModelTip,
    cut: Cut,
    spindle_speed: float,
    depth: float,
    *,
    periods: int = 200,
    steps: int = 200,
    kick: tuple[float, float, float] = (0.0, 0.0, 0.0),
    linear: bool = False,
) -> CutHistory:
    """Step the cut through time by a matrix exponential, the force linear in each step and corrected twice.

    Args:
        tip: the tip as a second-order system, without a measured receptance.
        cut: the cut; a feed per tooth is used if it says one.
        spindle_speed: [rev/min].
        depth: axial depth of cut [m].
        periods: tooth periods.
        steps: in each of them.
        kick: impulse on the tip at the start, along x, y, z of the cut [N·s].
        linear: teeth never leave the cut and chips may be negative: what the stability theory assumes.

    Raises:
        InvalidRequest: the tip holds a measured receptance.
    """
    if tip.added is not None:
        raise InvalidRequest(Fault("call", "tip", "a measured receptance", "a second-order system alone"))
    period = cut.tooth_period(spindle_speed)
    turn, first, second = _propagators(tip, period / steps)
    cutting = _Teeth(cut, depth, steps, linear=linear)
    total = periods * steps
    see = np.hstack([tip.rows, np.zeros_like(tip.rows)])
    state = np.zeros(2 * tip.system.dof)
    state[tip.system.dof :] = np.linalg.solve(tip.system.mass, tip.rows.T @ np.array(kick))
    moved, pushed = np.zeros((total, 3)), np.zeros((total, 3))
    force = cutting.force(0, moved[0])
    for step in range(total):
        moved[step], pushed[step] = see @ state, force
        cutting.keep(step, moved[step])
        if step == total - 1:
            break
        following = force
        free = turn @ state + first @ force
        for _ in range(_CORRECTIONS):
            following = cutting.force(step + 1, see @ (free + second @ following))
        state, force = free + second @ following, following
        if not np.all(np.abs(state) < 1e12):
            moved, pushed, total = moved[: step + 1], pushed[: step + 1], step + 1
            break
    return CutHistory(np.arange(total) * period / steps, moved, pushed, steps)


class _Teeth:
    """Cutting force at an instant, and the surface that the teeth before have left."""

    def __init__(self, cut: Cut, depth: float, steps: int, *, linear: bool) -> None:
        cutter, self.cut, self.linear, self.steps = cut.cutter, cut, linear, steps
        slices = _SLICES if cutter.helix > 0 else 1
        height = (np.arange(slices) + 0.5) * depth / slices
        self.lag = 2 * height * np.tan(cutter.helix) / cutter.diameter
        self.pitch = 2 * np.pi / cutter.teeth
        self.width = depth / slices / np.sin(cutter.approach)
        self.feed = cut.engagement.feed_per_tooth or 0.0
        self.surface = np.zeros((steps, cutter.teeth, slices))
        self.path, self.normal, self.edge, self.inside = self._turn(steps * cutter.teeth)

    def force(self, step: int, moved: np.ndarray) -> np.ndarray:
        """On the tip [N]."""
        at = step % len(self.inside)
        normal, inside = self.normal[at], self.inside[at]
        chip = normal @ moved + self.feed * normal[..., 0] - self._before(step)
        if not self.linear:
            inside = inside * (chip > 0)
        chip, here = (chip * inside)[..., None], (inside * (self.feed > 0))[..., None]
        specific, rub = self.cut.force.specific, self.cut.force.edge
        push = (
            (specific[0] * chip + rub[0] * here) * self.path[at]
            + (specific[1] * chip + rub[1] * here) * normal
            + (specific[2] * chip + rub[2] * here) * self.edge[at]
        )
        return -self.width * push.sum(axis=(0, 1))

    def keep(self, step: int, moved: np.ndarray) -> None:
        """What this step leaves for the tooth after."""
        at = step % len(self.inside)
        normal = self.normal[at]
        left = normal @ moved
        if not self.linear:
            # A tooth in the air leaves the old surface, which the feed has meanwhile brought nearer.
            old = self._before(step) - self.feed * normal[..., 0]
            left = np.where(self.inside[at] > 0, np.maximum(left, old), 0.0)
        self.surface[step % self.steps] = left

    def _before(self, step: int) -> np.ndarray:
        """Height of the surface along each tooth's normal, as the tooth before has left it."""
        return np.roll(self.surface[step % self.steps], -1, axis=0)

    def _turn(self, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Path, normal and edge of every tooth and slice at each step of a turn, and its part in the cut."""
        tip = self.pitch * (np.arange(count)[:, None] / self.steps + np.arange(self.cut.cutter.teeth))
        angle = np.mod(tip[:, :, None] - self.lag, 2 * np.pi)
        sk, ck = np.sin(self.cut.cutter.approach), np.cos(self.cut.cutter.approach)
        s, c, o = np.sin(angle), np.cos(angle), np.zeros_like(angle)
        inside = self._share(angle) + self._share(angle - 2 * np.pi)
        path, normal = np.stack([c, -s, o], -1), np.stack([s * sk, c * sk, o - ck], -1)
        return path, normal, np.stack([s * ck, c * ck, o + sk], -1), inside

    def _share(self, angle: np.ndarray) -> np.ndarray:
        """Part of a step about an angle that lies in the cut: 1 inside, 0 outside, between at the edges."""
        half = self.pitch / self.steps / 2
        begin, end = self.cut.engagement.entry, self.cut.engagement.exit
        overlap = np.minimum(angle + half, end) - np.maximum(angle - half, begin)
        return np.clip(overlap / (2 * half), 0, 1)


def _propagators(tip: ModelTip, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step of the state, and what the force at its start and at its end adds."""
    from scipy.linalg import expm

    dof, inverse = tip.system.dof, np.linalg.inv(tip.system.mass)
    whole = np.zeros((2 * dof + 6,) * 2)
    whole[:dof, dof : 2 * dof] = np.eye(dof)
    whole[dof : 2 * dof, :dof] = -inverse @ tip.system.stiffness
    whole[dof : 2 * dof, dof : 2 * dof] = -inverse @ tip.system.damping
    whole[dof : 2 * dof, 2 * dof : 2 * dof + 3] = inverse @ tip.rows.T
    whole[2 * dof : 2 * dof + 3, 2 * dof + 3 :] = np.eye(3) / width
    solved = expm(whole * width)[: 2 * dof]
    held, ramp = solved[:, 2 * dof : 2 * dof + 3], solved[:, 2 * dof + 3 :]
    return solved[:, : 2 * dof], held - ramp, ramp
