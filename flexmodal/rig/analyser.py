"""The analyser: an anti-aliasing filter, the same for every channel, and samples.

The structure is simulated on a grid `OVERSAMPLING` times finer than the analyser's. The filter is a sinc
windowed by Kaiser's window, evaluated as a function of continuous time: a channel that lags by d gets the
same filter shifted by d, exactly. It is flat to 1e-5 up to fs/2.5 and 100 dB down where lines fold back to
there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy.lib.stride_tricks import as_strided

OVERSAMPLING = 32
"""Grid of the simulation over the analyser's sampling rate, at least."""
RATIO = 2.56
"""Sampling rate over the highest line, as analysers have it."""
ATTENUATION = 100.0
"""Of the stop band [dB]."""
PRETRIGGER = 0.02
"""Part of the record before the blow."""


@dataclass(frozen=True)
class Analyser:
    """Sampling of one campaign."""

    rate: float
    """Samples a second [Hz]."""
    samples: int
    """In one record."""
    oversampling: int = OVERSAMPLING

    @property
    def interval(self) -> float:
        """Between samples [s]."""
        return 1 / self.rate

    @property
    def step(self) -> float:
        """Of the simulation's grid [s]."""
        return 1 / (self.rate * self.oversampling)

    @property
    def trigger(self) -> float:
        """When the pulse begins [s]: a whole number of samples, late enough for the filter's fore-ringing."""
        return (
            max(round(PRETRIGGER * self.samples), int(np.ceil(self.half_width * self.rate)) + 1) / self.rate
        )

    @cached_property
    def time(self) -> Float[np.ndarray, " sample"]:
        """Of the samples [s]."""
        return np.arange(self.samples) / self.rate

    @property
    def half_width(self) -> float:
        """Half the length of the filter [s]: Kaiser's formula for a transition from 0.4 to 0.6 fs."""
        return (ATTENUATION - 7.95) / (2 * 14.36 * 0.2 * self.rate)

    @property
    def reach(self) -> int:
        """Half the length of the filter in steps of the grid."""
        return int(np.ceil(self.half_width / self.step))

    def weights(self, delay: float = 0.0) -> Float[np.ndarray, " tap"]:
        """Filter weights over the grid, from `reach` steps ahead of a sample back to `reach` plus the delay.

        Sample n is Σ_j weights[j] · y(grid step n·oversampling + reach − j).
        """
        beta = 0.1102 * (ATTENUATION - 8.7)
        lag = np.arange(-self.reach, self.reach + int(np.ceil(delay / self.step)) + 1) * self.step - delay
        inside = np.clip(1 - (lag / self.half_width) ** 2, 0.0, None)
        window = np.where(np.abs(lag) <= self.half_width, np.i0(beta * np.sqrt(inside)), 0.0)
        kernel = np.sinc(self.rate * lag) * window
        return kernel / kernel.sum()

    def sampled(
        self,
        fine: Float[np.ndarray, "*many grid"],
        weights: Float[np.ndarray, " tap"],
        first: int,
        count: int,
    ) -> Float[np.ndarray, "*many count"]:
        """Filter and pick samples `first` to `first + count − 1` from the grid, zero before it begins.

        The grid is cut into blocks of one sample each and the filter into as many pieces: sample n is the sum
        over pieces k of piece k on block n + k. Each channel is worked out alone, so that it does not matter
        to a bit which others are with it.

        Args:
            fine: values on the grid, the last axis.
            weights: of the filter, see `weights`.
            first: number of the first sample.
            count: how many samples.
        """
        fold = self.oversampling
        pieces = np.pad(weights[::-1], (0, -len(weights) % fold)).reshape(-1, fold)
        blocks = count + len(pieces) - 1
        start = first * fold + self.reach - len(weights) + 1
        lead = max(0, -start)
        span = slice(start + lead, min(start + blocks * fold, fine.shape[-1]))
        out = np.empty((*fine.shape[:-1], count))
        padded = np.zeros(blocks * fold)
        for channel in np.ndindex(*fine.shape[:-1]):
            known = fine[channel][span]
            padded[lead : lead + len(known)] = known
            product = padded.reshape(blocks, fold) @ pieces.T
            diagonals = as_strided(
                product, (count, len(pieces)), (product.strides[0], sum(product.strides)), writeable=False
            )
            out[channel] = diagonals.sum(axis=1)
        return out
