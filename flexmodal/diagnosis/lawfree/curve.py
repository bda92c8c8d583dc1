"""What the free functions look like: the curve with its band, and the class of physics that it is nearest to.

A template is compared with the curve in the metric that the data give it once the robot's own parameters are
eliminated, for stiffness and damping of the robot shift the curve at no cost.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from flexmodal.diagnosis.lawfree.metric import Metric
from flexmodal.diagnosis.lawfree.result import Class, Curve
from flexmodal.diagnosis.lawfree.sighting import Sighting
from flexmodal.diagnosis.lawfree.templates import Template, templates_for

_NEXT = 6.0
"""Difference in score [2 nat] from which a class stands alone."""


def curve_of(sighting: Sighting, number: int = -1) -> tuple[Curve, Metric]:
    """The curve of a port's functions, with the metric on its changes.

    Args:
        sighting: of ports whose functions are the same in all postures.
        number: of the port; the last one by default.
    """
    profile, state, span = sighting.profile, sighting.state, sighting.profile.model.spans[number]
    metric = Metric.of_port(profile, state, span)
    port, z, size = sighting.ports[number], state.z[0, span], profile.model.size[span]
    scale = max(profile.reduced(state.residual), 1.0)
    model = profile.model
    curve = Curve(
        model.observations.axis.frequency[model.lines],
        port.names,
        port.kind.unit,
        z * size,
        np.sqrt(metric.variance * scale) * size,
    )
    return curve, metric


def classes_of(sighting: Sighting, curve: Curve, metric: Metric, number: int = -1) -> tuple[Class, ...]:
    """Classes of physics, the likeliest first.

    Args:
        sighting: of the port, perhaps with others.
        curve: of its functions.
        metric: on its changes.
        number: of the port; the last one by default.
    """
    span = sighting.profile.model.spans[number]
    size = sighting.profile.model.size[span]
    omega = 2 * np.pi * curve.frequency
    target = metric.of(sighting.state.z[0, span])
    count = len(target)
    fits = [
        (template, *_fitted(template, omega, size, metric, target))
        for template in templates_for(sighting.ports[number])
    ]
    spare = [max(count - _parameters(template, len(curve.names)), 1) for template, *_ in fits]
    least = min(2 * square / free for (_, square, *_), free in zip(fits, spare, strict=True))
    temper = max(least, 1.0)
    found = []
    for (template, square, at, linear), free in zip(fits, spare, strict=True):
        parameters = _parameters(template, len(curve.names))
        found.append(
            Class(
                template.name,
                template.words(at, linear, curve.names, curve.unit),
                tuple(tuple(row) for row in linear.tolist()),
                float(np.sqrt(2 * square / free)),
                1.0 - square / max(float(target @ target), 1e-300),
                float(2 * square / temper + parameters * np.log(count)),
            )
        )
    return tuple(sorted(found, key=lambda one: one.score))


def undecided(classes: Sequence[Class]) -> tuple[Class, ...]:
    """The classes that cannot be told from the likeliest, itself first."""
    return tuple(one for one in classes if one.score <= classes[0].score + _NEXT)


def _parameters(template: Template, functions: int) -> int:
    return len(template.grids) + template.terms * functions


def _fitted(
    template: Template, omega: np.ndarray, size: np.ndarray, metric: Metric, target: np.ndarray
) -> tuple[float, tuple[float, ...], Float[np.ndarray, "function term"]]:
    """Least square, parameters and coefficients of a template; linear ones are projected out.

    Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973.
    """
    functions = len(size)

    def solved(at: np.ndarray) -> tuple[float, np.ndarray]:
        matrix = metric.of_each(np.array(template.basis(omega, tuple(np.exp(at))), dtype=complex), size)
        norm = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        found = np.linalg.lstsq(matrix / norm, target, rcond=None)[0] / norm
        return float(np.sum((target - matrix @ found) ** 2)), found.reshape(functions, -1)

    if not template.grids:
        square, linear = solved(np.zeros(0))
        return square, (), linear
    grid = np.stack(np.meshgrid(*(np.log(one(omega)) for one in template.grids), indexing="ij"), axis=-1)
    tried = grid.reshape(-1, len(template.grids))
    start = min(tried, key=lambda at: solved(at)[0])
    bounds = list(zip(tried.min(axis=0), tried.max(axis=0), strict=True))
    best = minimize(
        lambda at: solved(at)[0], start, method="Nelder-Mead", bounds=bounds, options={"maxiter": 200}
    ).x
    square, linear = solved(best)
    return square, tuple(np.exp(best).tolist()), linear
