"""Observations with those beside them that were silent: what should stand there can be compared with.

Where a sensor has nothing to sense its record is noise, which no fit takes. But two labels may have been
exchanged of which one belongs to such a place; then noise stands under the other label, and a record under a
place where the model has none.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from flexmodal.campaign import FrfRecords
from flexmodal.identification import Observations


def with_silent(observations: Observations, records: FrfRecords) -> Observations:
    """The same, and every other pair of a channel and a hammer position of each posture, with no line used.

    Args:
        observations: of records with a signal.
        records: all of the campaign's.
    """
    channels = sorted({(int(p), abs(int(d))) for p, d in records.response})
    hammers = sorted({(int(p), abs(int(d))) for p, d in records.reference})
    keys = np.column_stack(
        [observations.posture, observations.response, observations.reference, observations.level]
    )
    there = set(map(tuple, keys.tolist()))
    kinds = sorted({(int(row[0]), int(row[5])) for row in keys})
    more = [
        (posture, *response, *reference, level)
        for (posture, level), response, reference in product(kinds, channels, hammers)
        if (posture, *response, *reference, level) not in there
    ]
    if not more:
        return observations
    table = np.array(more, dtype=int)
    empty = (len(more), observations.value.shape[1])
    return replace(
        observations,
        posture=np.concatenate([observations.posture, table[:, 0]]),
        response=np.concatenate([observations.response, table[:, 1:3]]),
        reference=np.concatenate([observations.reference, table[:, 3:5]]),
        level=np.concatenate([observations.level, table[:, 5]]),
        value=np.concatenate([observations.value, np.ones(empty, dtype=complex)]),
        variance=np.concatenate([observations.variance, np.full(empty, np.inf)]),
        used=np.concatenate([observations.used, np.zeros(empty, dtype=bool)]),
    )
