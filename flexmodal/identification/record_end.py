"""How long records go on after the blow, by the blows themselves or as is usual."""

from __future__ import annotations

import numpy as np

from flexmodal.campaign import PRETRIGGER, SAMPLING, Blow, Campaign, pulse_length


def length_after(campaign: Campaign, group: tuple[int, ...]) -> float:
    """Time from the middle of the blow to the end of the record [s].

    Of the blows, else as stated less a usual pre-trigger and half a usual pulse. The sum over samples that is
    taken for an integral ends half a sample before the last one's interval does.

    Args:
        campaign: with blows or FRFs.
        group: ids of trials that repeat each other.

    Returns:
        0 where nobody says how long records are.
    """
    found = [_after(blow) - blow.step / 2 for blow in campaign.blows if blow.trial in group]
    if not found:
        sample = 0.0 if campaign.frfs is None else 1 / (SAMPLING * float(campaign.frfs.frequency[-1]))
        trials = [campaign.trial(trial) for trial in group]
        found = [
            (1 - PRETRIGGER) * one.record_length - (pulse_length(one.tip, one.force_peak) + sample) / 2
            for one in trials
            if one.record_length is not None
        ]
    return max(float(np.median(found)), 0.0) if found else 0.0


def _after(blow: Blow) -> float:
    power = blow.force**2
    middle = float(np.sum(blow.time * power) / np.sum(power))
    return float(blow.time[0]) + len(blow.time) * blow.step - middle
