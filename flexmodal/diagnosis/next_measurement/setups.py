"""What could be measured next: postures, places of sensor and hammer, levels of force, locks and masses."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodal.campaign import CampaignPoint, CampaignPosture
from flexmodal.diagnosis.effects.context import Context, Place
from flexmodal.diagnosis.time_domain.pulse import Pulse
from flexmodal.identification import Observations
from flexmodal.text.frozen import FrozenDict

RANDOM = 24
"""Random postures that are tried beside the card's."""
BOLTED = 0.05
"""Mass that is bolted on, over that of the arm: what two hands can fasten, and enough to move every mode."""
HARDER = 3.0
"""Times the hardest blow so far that a blow of another kind has, where explanations depend on the force."""
_WIDEST = np.radians(150)
Plan = tuple[CampaignPosture, Sequence[tuple[Place, Place]]]
"""A posture, with what is locked and bolted on, and pairs of response and reference."""


@dataclass(frozen=True, eq=False)
class Bench:
    """A campaign's places and those besides that its robot's card has."""

    observations: Observations
    context: Context
    new: tuple[CampaignPoint, ...]
    """Points of the card that the campaign does not have yet."""

    @classmethod
    def of(cls, observations: Observations, context: Context) -> Bench:
        """Of a campaign.

        Args:
            observations: its FRFs.
            context: of its robot.
        """
        campaign = observations.campaign
        names = {point.name for point in campaign.points}
        free = itertools.count(max(point.id for point in campaign.points) + 1)
        frame = campaign.points[0].frame
        new = []
        for name, point in context.robot.points.items():
            if name not in names and point.link in _moving(context):
                x, y, z = (float(value) for value in point.xyz)
                new.append(CampaignPoint(next(free), name, point.link, (x, y, z), frame=frame))
        return cls(observations, context, tuple(new))

    @property
    def points(self) -> tuple[CampaignPoint, ...]:
        """All of them that a flexible joint moves."""
        own = (point for point in self.observations.campaign.points if point.link in _moving(self.context))
        return (*own, *self.new)

    @property
    def places(self) -> list[Place]:
        """Every point, along each of its directions."""
        return [(point.id, way) for point in self.points for way in (1, 2, 3)]

    @property
    def rows(self) -> list[tuple[Place, Place]]:
        """Pairs of response and reference that the campaign has."""
        seen = np.column_stack([self.observations.response, self.observations.reference])
        return [((a, b), (c, d)) for a, b, c, d in np.unique(seen, axis=0).tolist()]

    @property
    def other_rows(self) -> list[tuple[Place, Place]]:
        """Pairs with the sensor or the hammer somewhere else."""
        own = self.rows
        seen, struck = (list(dict.fromkeys(pair[k] for pair in own)) for k in (0, 1))
        pairs = [(place, other) for place in self.places for other in struck]
        pairs += [(place, other) for place in seen for other in self.places]
        return [pair for pair in dict.fromkeys(pairs) if pair not in own]

    @property
    def fixtures(self) -> list[tuple[tuple[str, ...], Mapping[str, float]]]:
        """One joint locked, or a mass bolted on at one point."""
        mass = float(f"{BOLTED * self.context.arm_mass:.1g}")
        locked = [((name,), FrozenDict[float]()) for name in self.context.joints]
        return [*locked, *(((), FrozenDict({point.name: mass})) for point in self.points)]

    def levels(self, *, by_force: bool) -> list[int]:
        """Numbers of the kinds of blow; one more, harder than all, where explanations depend on the force.

        Args:
            by_force: whether they do.
        """
        own = [int(one) for one in np.unique(self.observations.level)]
        return [*own, len(self.observations.levels)] if by_force else own

    def peak(self, level: int) -> float:
        """Typical force of a kind of blow [N], the harder one that was not struck yet among them.

        Args:
            level: see `levels`.
        """
        seen = self.observations
        if level < len(seen.levels):
            return seen.peak(level)
        return HARDER * max(seen.peak(number) for number in range(len(seen.levels)))

    def planned(self, plans: Sequence[Plan], levels: Sequence[int]) -> tuple[Observations, Context]:
        """Observations of postures in which nothing is measured yet, and the context of their effects.

        Args:
            plans: postures, and pairs of response and reference in each.
            levels: see `levels`.
        """
        seen, campaign = self.observations, self.observations.campaign
        pulses, peaks = self.context.pulses, dict(self.context.peaks or {})
        trials, groups = campaign.trials, seen.levels
        decays, lengths = seen.decays, seen.lengths
        if len(groups) in levels:
            hardest = max(peaks, key=lambda number: peaks[number])
            peak, like = HARDER * peaks[hardest], campaign.trial(groups[hardest][0])
            number = max(trial.id for trial in trials) + 1
            trials = (*trials, replace(like, id=number, force_peak=peak, repeat_of=None))
            groups = (*groups, (number,))
            decays, lengths = (*decays, decays[hardest]), (*lengths, lengths[hardest])
            shorter = pulses[hardest].length * HARDER ** (-1 / 6)  # Hertz's contact; see `pulse`
            pulses, peaks[len(groups) - 1] = (*pulses, Pulse(peak, shorter)), peak
        points = (*campaign.points, *self.new)
        postures = tuple(  # named anew, for one may be there several times with other locks
            replace(posture, id=k, name=f"planned_{k}") for k, (posture, _) in enumerate(plans, start=1)
        )
        table = np.array(
            [(*u, *v, level, k) for k, (_, rows) in enumerate(plans) for u, v in rows for level in levels]
        )
        shape = len(table), seen.value.shape[1]
        planned = replace(
            seen,
            campaign=replace(
                campaign, points=points, postures=postures, trials=trials, frfs=None, blows=(), modes=None
            ),
            postures=postures,
            posture=table[:, 5],
            response=table[:, :2],
            reference=table[:, 2:4],
            level=table[:, 4],
            levels=groups,
            decays=decays,
            lengths=lengths,
            value=np.ones(shape, dtype=complex),
            variance=np.zeros(shape),
            used=np.ones(shape, dtype=bool),
        )
        there = replace(self.context, postures=postures, points=points, pulses=pulses, peaks=peaks)
        return planned, there


def _moving(context: Context) -> frozenset[str]:
    """Links that a flexible joint moves."""
    arm = context.arms[0]
    return frozenset(link for link, motion in arm.maps.items() if motion.any())


def postures_to_try(context: Context, seed: int) -> list[Mapping[str, float]]:
    """The card's postures, those of the campaign, and random ones.

    Args:
        context: whose robot and campaign.
        seed: of the random ones.
    """
    robot, random = context.robot, np.random.default_rng(seed)
    found: list[Mapping[str, float]] = [dict(q) for q in robot.postures.values()]
    found += [dict(p.q) for p in context.postures]
    for _ in range(RANDOM):
        values = {}
        for name, joint in robot.commanded.items():
            wide = _WIDEST if not joint.is_prismatic else 0.5
            low, high = max(joint.lower, -wide), min(joint.upper, wide)
            values[name] = float(random.uniform(low, high)) if low < high else float(joint.lower)
        found.append(values)
    return found
