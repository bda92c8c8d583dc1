"""Intervals of the clustered sandwich, over many drawn experiments of a linear model."""

import numpy as np
import pytest

from flexmodal.identification.uncertainty import sandwich
from flexmodal.structure.parameter import Parameter, ParameterSpace


def drawn(random, clusters, lines, shared, prior):
    """Lines of each cluster share a part of their error along a slope that no parameter has."""
    size = 4
    space = ParameterSpace(tuple(Parameter(f"p{k}", "", 1.0, prior, log=False) for k in range(size)))
    truth = random.normal(0, prior if np.isfinite(prior) else 1.0, size)
    design = random.normal(size=(clusters, lines, size)) + random.normal(size=(clusters, 1, size))
    pattern = np.ones(lines) + 0.5 * np.sin(np.arange(lines))
    error = random.normal(size=(clusters, lines)) + shared * random.normal(size=(clusters, 1)) * pattern
    block = np.swapaxes(design, 1, 2) @ design
    a = block.sum(axis=0) + np.diag(space.precision)
    x = np.linalg.solve(a, np.einsum("clp,cl->p", design, design @ truth + error))
    r = design @ (x - truth) - error
    return x, truth, sandwich(space, np.einsum("clp,cl->cp", design, r), block)


@pytest.mark.parametrize(
    ("clusters", "shared", "prior"), [(8, 0.0, np.inf), (8, 1.0, np.inf), (16, 2.0, 0.3)]
)
def test_95_per_cent_intervals_hold_the_truth_about_that_often(clusters, shared, prior):
    random = np.random.default_rng(11)
    hits = []
    for _ in range(300):
        x, truth, found = drawn(random, clusters, 20, shared, prior)
        low, high = found.interval(x)
        hits.append((low <= truth) & (truth <= high))
    share = float(np.mean(hits))
    assert 0.92 < share < 0.985, (
        share
    )  # 1200 intervals: 0.95 ± 0.02 at three standard deviations, few clusters widen


def test_without_shared_errors_and_many_clusters_it_is_least_squares():
    random = np.random.default_rng(3)
    ratio = []
    for _ in range(30):
        _, _, found = drawn(random, 200, 5, 0.0, np.inf)
        ratio.append(np.diag(found.covariance) / np.diag(np.linalg.inv(found.information)))
    assert abs(float(np.mean(ratio)) - 1) < 0.05  # 30 × 4 variances of 200 clusters each: ± 0.01
    assert np.all(found.freedom > 50)


def test_what_nothing_tells_keeps_its_prior():
    space = ParameterSpace((Parameter("seen", "", 1.0, 0.5), Parameter("unseen", "", 1.0, 0.3)))
    block = np.zeros((6, 2, 2))
    block[:, 0, 0] = 100.0
    score = np.zeros((6, 2))
    score[:, 0] = [10, -8, 6, -12, 9, -5]
    found = sandwich(space, score, block)
    assert found.deviation[1] == pytest.approx(0.3)
    assert found.identified == ("seen",)
    low, high = found.interval(np.zeros(2))
    assert high[1] - low[1] == pytest.approx(2 * 1.959964 * 0.3, rel=1e-5)
