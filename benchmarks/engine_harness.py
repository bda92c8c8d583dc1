"""Ratios on a noisy machine: all variants in turn, round after round; the median of the rounds' ratios.

Processor time counts, not the clock on the wall: all runs on one thread, and the machine may be shared.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Ratio:
    """How many times as fast as the reference, or as long: median and quartiles over the rounds."""

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        """The median, and the quartiles after it."""
        return f"{self.median:.3g} ({self.low:.3g}–{self.high:.3g})"

    def times(self, factor: float) -> Ratio:
        """Scaled."""
        return Ratio(self.median * factor, self.low * factor, self.high * factor)


@dataclass(frozen=True)
class Run:
    """Seconds a point, by variant and round."""

    seconds: Mapping[str, np.ndarray]

    def faster(self, name: str, reference: str) -> Ratio:
        """How many times as fast as the reference."""
        return _summary(self.seconds[reference] / self.seconds[name])

    def longer(self, name: str, reference: str) -> Ratio:
        """How many times as long as the reference."""
        return _summary(self.seconds[name] / self.seconds[reference])

    def median(self, name: str) -> float:
        """Median seconds a point; only for orientation, the machine is shared."""
        return float(np.median(self.seconds[name]))


def interleaved(variants: Mapping[str, tuple[Callable[[], object], int]], rounds: int) -> Run:
    """Time variants in turn.

    Args:
        variants: by name, what to call and how many points one call does.
        rounds: how often; each variant is called once before, so that nothing is compiled or loaded inside.
    """
    for call, _ in variants.values():
        call()
    seconds: dict[str, list[float]] = {name: [] for name in variants}
    for _ in range(rounds):
        for name, (call, points) in variants.items():
            start = time.process_time()
            call()
            seconds[name].append((time.process_time() - start) / points)
    return Run({name: np.array(values) for name, values in seconds.items()})


def _summary(ratios: np.ndarray) -> Ratio:
    low, median, high = np.percentile(ratios, [25, 50, 75])
    return Ratio(float(median), float(low), float(high))
