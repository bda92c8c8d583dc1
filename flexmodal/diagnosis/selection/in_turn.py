"""Which of several effects that gain about as much is added first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.comparison import Comparison, M
from flexmodal.diagnosis.selection.decision import Answer, gains_enough

ABOUT_AS_MUCH = 0.8
"""Part of what the best gains that another one gains, to come before it: of a coupling beside friction, where
both are there, it was 0.97."""


def linear_first(
    comparison: Comparison[M],
    chosen: int,
    worth: Sequence[Answer],
    plausible: Mapping[int, float],
    is_slow: Callable[[M], bool],
) -> int:
    """The best linear effect in place of one whose torque is integrated, if it gains about as much.

    Whatever is looked for beside such a torque takes much longer, and where it does not explain
    everything others have to be. It is still there to be found beside the linear one.

    Args:
        comparison: of the model as it is and of what might be added.
        chosen: number of what would be.
        worth: of each model whether it takes enough away besides.
        plausible: of those that explain everything, by number, how plausible they are [nat].
        is_slow: whether a model has such torques.
    """
    models = comparison.models
    if chosen in plausible or is_slow(models[0]) or not is_slow(models[chosen]):
        return chosen
    least = ABOUT_AS_MUCH * comparison.first_gain(chosen)
    able = [
        k
        for k, one in enumerate(models)
        if k and one.key[0] != UNSTRUCTURED and not is_slow(one)
        if comparison.first_gain(k) >= least and min(worth[k], gains_enough(comparison, k)) is Answer.YES
    ]
    return max(able, key=comparison.first_gain, default=chosen)
