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
_LARGEST = 1e12
"""A state beyond this ends the simulation: the linear theory knows no bounds."""


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

        Of a linear simulation without feed this is the size of the largest Floquet multiplier.

        Raises:
            InvalidRequest: nothing moves in them, as without kick and feed.
        """
        tail = self.displacement[-periods * self.steps :].reshape(periods, -1)
        length = np.linalg.norm(tail, axis=1)
        if not np.all(length > 0):
            raise InvalidRequest(
                Fault("call", "periods", "periods without motion", "a cut with kick or feed")
            )
        size = np.log(length)
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
    direct = see @ second
    state = np.zeros(2 * tip.system.dof)
    state[tip.system.dof :] = np.linalg.solve(tip.system.mass, tip.rows.T @ np.array(kick))
    moved, pushed = np.zeros((total, 3)), np.zeros((total, 3))
    cutting.stand(0)
    force = cutting.force(moved[0])
    for step in range(total):
        moved[step], pushed[step] = see @ state, force
        cutting.keep(moved[step])
        cutting.stand(step + 1)
        free = turn @ state + first @ force
        seen = see @ free
        following = force
        for _ in range(_CORRECTIONS):
            following = cutting.force(seen + direct @ following)
        state, force = free + second @ following, following
        if not abs(state).max() < _LARGEST:
            moved, pushed, total = moved[: step + 1], pushed[: step + 1], step + 1
            break
    return CutHistory(np.arange(total) * period / steps, moved, pushed, steps)


class _Teeth:
    """Cutting force at an instant, and the surface that the teeth before have left.

    Arrays run over the steps of a turn, then over teeth and slices as one.
    """

    def __init__(self, cut: Cut, depth: float, steps: int, *, linear: bool) -> None:
        cutter, self.cut, self.linear, self.steps = cut.cutter, cut, linear, steps
        slices = _SLICES if cutter.helix > 0 else 1
        height = (np.arange(slices) + 0.5) * depth / slices
        self.lag = 2 * height * np.tan(cutter.helix) / cutter.diameter
        self.pitch = 2 * np.pi / cutter.teeth
        path, normal, edge, inside = self._turn(steps * cutter.teeth)
        width = (depth / slices / np.sin(cutter.approach) * inside)[..., None]
        feed = cut.engagement.feed_per_tooth or 0.0
        self.normal, self.inside = normal, inside > 0
        self.fed = feed * normal[..., 0]
        self.cutting = -width * sum(
            k * v for k, v in zip(cut.force.specific, (path, normal, edge), strict=True)
        )
        self.rubbing = -width * sum(k * v for k, v in zip(cut.force.edge, (path, normal, edge), strict=True))
        self.rubbing *= feed > 0
        self.surface = np.zeros((steps, cutter.teeth * slices))
        self.now, self.old, self.slices = 0, self.surface[0], slices

    def stand(self, step: int) -> None:
        """Turn the cutter to a step: of the surface each tooth meets what the one before has left."""
        self.now, self.slot = step % len(self.inside), step % self.steps
        before = self.surface[self.slot]
        # In the frame that moves with the feed the old surface has come nearer.
        self.old = np.concatenate([before[self.slices :], before[: self.slices]]) - self.fed[self.now]

    def force(self, moved: np.ndarray) -> np.ndarray:
        """On the tip where it is [N]."""
        chip = self.normal[self.now] @ moved - self.old
        if self.linear:
            return chip @ self.cutting[self.now] + self.rubbing[self.now].sum(axis=0)
        touching = chip > 0
        return (chip * touching) @ self.cutting[self.now] + touching @ self.rubbing[self.now]

    def keep(self, moved: np.ndarray) -> None:
        """What this step leaves for the tooth after; a tooth in the air leaves what there was."""
        left = self.normal[self.now] @ moved
        if not self.linear:
            left = np.where(self.inside[self.now], np.maximum(left, self.old), 0.0)
        self.surface[self.slot] = left

    def _turn(self, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Path, normal and edge of every tooth and slice at each step of a turn, and its part in the cut."""
        tip = self.pitch * (np.arange(count)[:, None] / self.steps + np.arange(self.cut.cutter.teeth))
        angle = np.mod(tip[:, :, None] - self.lag, 2 * np.pi).reshape(count, -1)
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
