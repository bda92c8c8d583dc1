"""Records that are wrong: second hits, coupling, overload, drift, FRFs of another test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Blow, Campaign, place_text
from flexmodal.rig.laboratory.draws import some_channel, some_posture


def double_hit(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """Every third blow of a posture hits again, 0.6 to 0.95 of the first, 12 to 40 ms later.

    What was recorded is linear in the blow: the second hit is the record once more, later and smaller.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    posture = some_posture(campaign, random)
    part, later = float(random.uniform(0.6, 0.95)), float(random.uniform(0.012, 0.04))

    def change(blow: Blow) -> Blow:
        if blow.posture != posture or blow.sequence % 3:
            return blow
        shift = max(1, round(later / blow.step))
        return replace(
            blow,
            force=blow.force + part * _later(blow.force, shift),
            response=blow.response + part * _later(blow.response, shift),
        )

    blows = tuple(change(blow) for blow in campaign.blows)
    return replace(campaign, blows=blows), f"posture {posture}, {1e3 * later:.0f} ms"


def coupled_response(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One acceleration channel behind a high pass of half to twice the band's lower end.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    place = some_channel(campaign, random)
    corner = float(campaign.band[0] * np.exp(random.uniform(np.log(0.5), np.log(2.0))))
    step = campaign.blows[0].step
    passed = partial(high_passed, corner=corner, step=step)
    return _changed(campaign, place, passed), f"{place_text(place)}, {corner:.2g} Hz"


def coupled_force(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """The force channel behind a high pass of half to twice the band's lower end.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    corner = float(campaign.band[0] * np.exp(random.uniform(np.log(0.5), np.log(2.0))))
    blows = tuple(replace(blow, force=high_passed(blow.force, corner, blow.step)) for blow in campaign.blows)
    return replace(campaign, blows=blows), f"the force, {corner:.2g} Hz"


def overload(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One channel of a posture cut at 0.3 to 0.6 of its peak.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    posture = some_posture(campaign, random)
    place = some_channel(campaign, random, posture)
    part = float(random.uniform(0.3, 0.6))

    def cut(values: Float[np.ndarray, "row sample"]) -> Float[np.ndarray, "row sample"]:
        most = part * np.abs(values).max()
        return np.clip(values, -most, most)

    return _changed(campaign, place, cut, posture), f"{place_text(place)} in posture {posture}"


def drift(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """One channel of a posture runs away by 0.5 to 2 of its root mean square over the record.

    Args:
        campaign: as it should be.
        random: what is drawn from.
    """
    posture = some_posture(campaign, random)
    place = some_channel(campaign, random, posture)
    part = float(random.uniform(0.5, 2.0))

    def run_away(values: Float[np.ndarray, "row sample"]) -> Float[np.ndarray, "row sample"]:
        size = np.sqrt(np.mean(values**2, axis=1, keepdims=True))
        return values + part * size * np.linspace(0, 1, values.shape[1])

    return _changed(campaign, place, run_away, posture), f"{place_text(place)} in posture {posture}"


def other_frfs(campaign: Campaign, random: np.random.Generator) -> tuple[Campaign, str]:
    """The FRFs of two postures exchanged beside blows that are right; scaled where there is one.

    Args:
        campaign: as it should be, with its FRFs.
        random: what is drawn from.
    """
    frfs = campaign.frfs
    assert frfs is not None
    if len(campaign.postures) < 2:
        return replace(campaign, frfs=replace(frfs, value=2 * frfs.value)), "every FRF, twice as large"
    one, other = (int(k) for k in random.choice(len(campaign.postures), 2, replace=False))
    first, second = campaign.postures[one].id, campaign.postures[other].id
    posture = np.where(frfs.posture == first, second, np.where(frfs.posture == second, first, frfs.posture))
    spoilt = replace(campaign, frfs=replace(frfs, posture=posture))
    return spoilt, f"postures {first} and {second}"


def high_passed(
    values: Float[np.ndarray, "*many sample"], corner: float, step: float
) -> Float[np.ndarray, "*many sample"]:
    """Records behind a first-order high pass (bilinear transform).

    Args:
        values: samples.
        corner: [Hz].
        step: time between two samples [s].
    """
    from scipy.signal import butter, lfilter

    b, a = butter(1, corner, btype="highpass", fs=1 / step)
    return np.asarray(lfilter(b, a, values, axis=-1))


def _changed(
    campaign: Campaign,
    place: tuple[int, int],
    change: Callable[[Float[np.ndarray, "row sample"]], Float[np.ndarray, "row sample"]],
    posture: int | None = None,
) -> Campaign:
    """One channel's records changed, in one posture or in every one."""

    def changed(blow: Blow) -> Blow:
        rows = [k for k, one in enumerate(blow.channels) if one == place]
        if posture not in (None, blow.posture) or not rows:
            return blow
        response = blow.response.copy()
        response[rows] = change(response[rows])
        return replace(blow, response=response)

    return replace(campaign, blows=tuple(changed(blow) for blow in campaign.blows))


def _later(values: Float[np.ndarray, "*many sample"], shift: int) -> Float[np.ndarray, "*many sample"]:
    moved = np.zeros_like(values)
    moved[..., shift:] = values[..., :-shift]
    return moved
