"""A modes-only campaign made ready for effects, which look at a campaign through its FRFs.

Effects and hypotheses know postures, points and a band by `Observations`. Where there are only modes, a
stand-in says the same with nothing measured in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodal.campaign import Campaign, CampaignPosture, FrfRecords
from flexmodal.identification import Observations
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.model import Robot

LINES = 64
ABOVE = 1.5
"""Times the highest natural frequency at which a band without an upper end is taken to end."""

Place = tuple[int, int]


def placed_on(campaign: Campaign, robot: Robot) -> tuple[Campaign, tuple[str, ...]]:
    """The campaign with points on links that the robot lacks put where its card has a point of that name.

    A campaign names links of one card; a card with fewer links, the same arm without a pseudo-joint, say,
    keeps its points under the same names elsewhere.

    Returns:
        The campaign, and a sentence for each point that was moved.
    """
    points, said = [], []
    for point in campaign.points:
        known = robot.points.get(point.name)
        if point.link in robot.urdf.link_by_name or known is None:
            points.append(point)
            continue
        x, y, z = (float(value) for value in known.xyz)
        points.append(replace(point, link=known.link, xyz=(x, y, z)))
        said.append(
            f"{point.name} sits on {point.link!r}, which {robot.name} does not have; "
            f"its card has a point of that name on {known.link!r}, which was taken"
        )
    return (replace(campaign, points=tuple(points)) if said else campaign), tuple(said)


def band_of(campaign: Campaign) -> tuple[float, float]:
    """The campaign's band; where it has no upper end, up to somewhat above its highest mode [Hz]."""
    low, high = campaign.band
    if not np.isfinite(high):
        assert campaign.modes is not None
        high = ABOVE * float(np.nanmax(campaign.modes.natural_frequency))
    return low, high


def places_of_modes(observed: ModeObservations) -> tuple[tuple[Place, ...], tuple[Place, ...]]:
    """Every response and every reference that some shape has: point ids and directions."""
    responses: dict[Place, None] = {}
    references: dict[Place, None] = {}
    for mode in observed.modes:
        for shape in mode.shapes:
            responses |= dict.fromkeys((int(p), int(d)) for p, d in shape.places)
            references[shape.reference] = None
    return tuple(sorted(responses)), tuple(sorted(references))


def stand_in(
    campaign: Campaign,
    postures: Sequence[CampaignPosture],
    responses: Sequence[Place],
    references: Sequence[Place],
) -> Observations:
    """Observations of every pair in every posture, with no line used.

    Args:
        campaign: whose points and band.
        postures: to be looked at; any.
        responses: point ids and directions.
        references: likewise; the first point's where there is none.
    """
    struck = list(references) or [responses[0]]
    table = np.array([[*u, *v] for _ in postures for v in struck for u in responses], dtype=int)
    count = len(struck) * len(responses)
    posture = np.repeat(np.arange(len(postures)), count)
    frequency = np.linspace(*band_of(campaign), LINES)
    size = (len(table), LINES)
    records = FrfRecords(
        frequency=frequency, value=np.ones(size, dtype=complex), coherence=None,
        posture=np.array([postures[k].id for k in posture.tolist()], dtype=int),
        trial=np.full(len(table), campaign.trials[0].id if campaign.trials else 1, dtype=int),
        response=table[:, :2], reference=table[:, 2:], form="receptance",
    )  # fmt: skip
    return Observations(
        campaign=campaign, records=records, postures=tuple(postures), posture=posture,
        response=table[:, :2], reference=table[:, 2:], level=np.zeros(len(table), dtype=int),
        levels=((records.trial[0].item(),),), decays=(0.0,), lengths=(0.0,),
        value=records.value, variance=np.zeros(size), used=np.zeros(size, dtype=bool),
        of_record=np.arange(len(table)), noise=np.zeros(size),
    )  # fmt: skip
