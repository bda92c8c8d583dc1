"""Where a fit of a foundation sets out: its law laid beside the compliances that were found free of one.

The compliance of the law, (K + iωB − ω²M)⁻¹, is compared with the free one line by line, in the metric of how
well each line and each way of moving is known: motion that nobody measured says nothing. That takes no
structure, so that many starts cost little. Resonances that do not fall together yet look alike to a sharp
metric wherever they are; so the free functions count as uncertain by a part of themselves at first, which
falls to nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import least_squares

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.foundation import Spring, every_term, motions, terms
from flexmodal.diagnosis.effects.foundation_law import FoundationLaw
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.structure import Parameter, ParameterSpace
from flexmodal.structure.arm import carried

SOFTENED = ((1.0, 24), (0.3, 8), (0.1, 4), (0.03, 3), (0.0, 2))
"""Relative uncertainty of the functions beside that of the data, and how many starts are followed there."""
FEW, MANY = 12, 60
"""Evaluations of each, and of the last ones."""
OUTLYING = 3.0
"""Distance, over what the data allow, from which a line weighs less."""
RIDGE = 1e-9
"""Of what is known best, known at least of every combination of functions."""


def told_by(
    context: Context,
    free: FreeFunction,
    parameters: Sequence[Parameter],
    starts: Sequence[Mapping[str, float]],
    bolts: Callable[[Placement], Sequence[Spring]] | None = None,
) -> list[dict[str, float]]:
    """Parameters of foundations whose compliance is nearest to free functions.

    Args:
        context: of the diagnosis.
        free: of the foundation's port, about an upright axis or between any two of its coordinates.
        parameters: of the law.
        starts: values of them to set out from.
        bolts: springs between the foundation and the root, if there are any.

    Returns:
        Two at most; none where nothing says how well the functions are known.
    """
    if free.information is None:
        return []
    laid = _Laid(context, free, parameters, bolts)
    found = [laid.coordinates(one) for one in starts]
    for part, followed in SOFTENED:
        metric = laid.metric(part)
        near = sorted(found, key=lambda x: laid.cost(x, metric))[:followed]
        found = [laid.nearest(x, metric, FEW if part else MANY) for x in near]
    return [laid.space.values(x) for x in sorted(found, key=lambda x: laid.cost(x, metric))]


class _Laid:
    """Free functions, and foundations to be laid beside them."""

    def __init__(
        self,
        context: Context,
        free: FreeFunction,
        parameters: Sequence[Parameter],
        bolts: Callable[[Placement], Sequence[Spring]] | None,
    ) -> None:
        """Take what the functions weigh.

        Args:
            context: of the diagnosis.
            free: with its information.
            parameters: of the law.
            bolts: see `told_by`.
        """
        assert free.information is not None
        _, motion = motions(context.normal)
        self.space, self.target = ParameterSpace(tuple(parameters)), free.value.T
        some = terms(context)
        pairs = np.array(some if len(free.value) == len(some) else every_term(context)).T
        self._scale, self._covariance = _uncertainty(free.information)
        axis = np.array([free.geometry.get(name, 0.0) for name in ("aside", "ahead")])
        back = np.linalg.inv(motion.T @ carried(motion, -np.array([*axis, 0.0])))
        self.law = FoundationLaw(context, self.space, bolts, 2 * np.pi * free.frequency, back, pairs)
        self.deviation = np.array([one.deviation for one in parameters])

    def coordinates(self, values: Mapping[str, float]) -> Float[np.ndarray, " parameter"]:
        """Of a fit, from values that the law has here, inside bounds; else the middle of the prior."""
        low, high = self.space.bounds
        known = {name: value for name, value in values.items() if name in self.space.index}
        return np.clip(self.space.coordinates(known), low + 1e-9, high - 1e-9)

    def metric(self, part: float) -> Complex[np.ndarray, "line function function"]:
        """Root of the information, each function uncertain by a part of itself besides."""
        uncertain = part * self._scale * np.abs(self.target)
        own = np.einsum("lf,fg->lfg", uncertain**2, np.eye(len(self._scale)))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self._covariance + own)) * self._scale)

    def far(
        self, x: Float[np.ndarray, " parameter"], metric: Complex[np.ndarray, "line function function"]
    ) -> Float[np.ndarray, " value"]:
        """How far a foundation is from the functions, and its parameters from their priors."""
        gap = (metric @ (self.law.compliance(x) - self.target)[:, :, None]).ravel()
        return np.concatenate([gap.real, gap.imag, x / self.deviation])

    def slopes(
        self, x: Float[np.ndarray, " parameter"], metric: Complex[np.ndarray, "line function function"]
    ) -> Float[np.ndarray, "value parameter"]:
        """Derivatives of that."""
        along = (metric @ self.law.slopes(x)).reshape(-1, len(x))
        return np.concatenate([along.real, along.imag, np.diag(1 / self.deviation)])

    def cost(
        self, x: Float[np.ndarray, " parameter"], metric: Complex[np.ndarray, "line function function"]
    ) -> float:
        """Robust half sum of squares."""
        square = (self.far(x, metric) / OUTLYING) ** 2
        return float(OUTLYING**2 * np.sum(np.sqrt(1 + square) - 1))

    def nearest(
        self,
        start: Float[np.ndarray, " parameter"],
        metric: Complex[np.ndarray, "line function function"],
        steps: int,
    ) -> Float[np.ndarray, " parameter"]:
        """Coordinates of the nearest foundation from a start."""
        made = least_squares(
            self.far, start, jac=self.slopes, args=(metric,), bounds=self.space.bounds,
            x_scale=self.deviation, loss="soft_l1", f_scale=OUTLYING, max_nfev=steps,
        )  # fmt: skip
        return np.asarray(made.x)


def _uncertainty(
    information: Complex[np.ndarray, "line function function"],
) -> tuple[Float[np.ndarray, " function"], Complex[np.ndarray, "line function function"]]:
    """Scales of functions, 0 where nothing is known anywhere, and covariances of the functions so scaled.

    By eigenvalues, since what is inverted twice has lost its positive ones where little is known.
    """
    scale = np.sqrt(np.abs(np.einsum("lff->lf", information)).max(axis=0))
    some = np.where(scale > 0, scale, 1.0)
    known, way = np.linalg.eigh(information / np.outer(some, some))
    covariance = way / np.maximum(known, RIDGE)[:, None, :] @ np.conj(np.swapaxes(way, 1, 2))
    return scale, covariance
