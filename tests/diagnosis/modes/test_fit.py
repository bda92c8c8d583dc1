"""Parts of a fit to modes by second routes: poles, likelihood, evidence."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import hyp1f1

from flexmodal.identification.evidence.likelihood.fit import fit_modes
from flexmodal.identification.evidence.likelihood.laplace import hessian
from flexmodal.identification.evidence.likelihood.likelihood import Likelihood
from flexmodal.identification.evidence.likelihood.residuals import residuals
from flexmodal.identification.evidence.likelihood.scatter import Beliefs, log_anywhere, log_watson_constant
from flexmodal.identification.evidence.likelihood.spectrum import spectrum
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.modal.mac import shape_residual
from flexmodal.structure.poles import poles


@pytest.mark.parametrize("key", [None, ("local_absorber", "link_2"), ("link_flexibility", "link_3")])
def test_all_postures_at_once_are_what_each_is_by_itself(explained_by, places, key):
    explanation = explained_by(key)
    x = np.random.default_rng(1).normal(0, 0.05, len(explanation.space))
    names = explanation.hypothesis.space.names
    structures = explanation.hypothesis.structures(x, [places[3], places[0]], places[:1], slopes=True)
    found = spectrum(structures, names)
    for number, structure in enumerate(structures):
        one = poles(structure, names)
        n = found.count[number]
        pole = one.pole[: one.count]
        still = np.flatnonzero(pole.imag > 0)
        assert n == len(still)
        np.testing.assert_allclose(found.pole[number, :n], pole[still], rtol=1e-9)
        np.testing.assert_allclose(
            found.pole_slope[number, :, :n],
            one.pole_slope[:, still],
            rtol=1e-6,
            atol=1e-7 * np.abs(pole).max(),
        )
        # shapes have a sign of their own: compare what does not
        seen, whole = found.seen[number, :, :n], structure.response @ one.shape[:, still]
        np.testing.assert_allclose(seen[0] * seen[1], whole[0] * whole[1], rtol=1e-6, atol=1e-12)


def test_slopes_of_forecasts_are_those_of_differences(explained_by, places):
    explanation = explained_by(("link_flexibility", "link_2"))
    x = np.random.default_rng(2).normal(0, 0.03, len(explanation.space))
    (seen, *_) = explanation.forecasts(x, places, slopes=True)
    a = seen.shape[:, 1] / np.linalg.norm(seen.shape[:, 1]) + 0.1
    a /= np.linalg.norm(a)
    _, turned = shape_residual(a, seen.shape[:, 1], seen.shape_slope[:, :, 1])
    for k in range(len(x)):
        step = 1e-5 * np.eye(len(x))[k]
        up, down = (explanation.forecasts(x + s * step, places, slopes=False)[0] for s in (1, -1))
        # central differences: h² and rounding over h; an effect's own slopes are forward differences of 1e-6
        for name, slope in (("log_frequency", seen.frequency_slope), ("log_damping", seen.damping_slope)):
            numeric = (getattr(up, name)[:3] - getattr(down, name)[:3]) / 2e-5
            np.testing.assert_allclose(slope[k, :3], numeric, rtol=1e-3, atol=2e-5)
        away = [
            np.sum(shape_residual(a, s.shape[:, 1], seen.shape_slope[:, :, 1])[0] ** 2) for s in (up, down)
        ]
        residual = shape_residual(a, seen.shape[:, 1], seen.shape_slope[:, :, 1])[0]
        assert 2 * turned[k] @ residual == pytest.approx((away[0] - away[1]) / 2e-5, abs=2e-4)


def test_the_watson_constant_is_kummers_function():
    for n in (2, 4, 6):
        for kappa in (1e-3, 0.5, 3.0, 40.0, 300.0):
            assert log_watson_constant(n, kappa) == pytest.approx(
                np.log(hyp1f1(1, n, kappa)), rel=1e-9, abs=1e-9
            )
    # and makes a density: the MAC of a random shape of n places is Beta(1, n − 1)
    total = quad(lambda t: np.exp(7.0 * t) * 4 * (1 - t) ** 3, 0, 1)[0]
    assert log_watson_constant(5, 7.0) == pytest.approx(np.log(total), rel=1e-9)


def test_a_peak_from_anywhere_has_the_density_of_that_many_peaks():
    beliefs = Beliefs(spurious=0.7)
    density = quad(lambda f: np.exp(log_anywhere((2.0, 200.0), beliefs, np.nan)) / f, 2.0, 200.0)[0]
    assert density == pytest.approx(0.7, rel=1e-9)


@pytest.mark.slow
def test_the_evidence_is_that_of_importance_sampling(explained_by, as_believed):
    """Laplace's integral against a sum over draws from a wider bell around the same place."""
    explanation = explained_by()
    modes = modes_of_table(as_believed)
    beliefs = Beliefs()
    fit = fit_modes(explanation, modes, np.zeros(len(explanation.space)), beliefs)
    assert min(fit.pairs) >= 0
    likelihood = Likelihood(explanation, modes, beliefs)
    names = list(fit.scales)
    found = residuals(likelihood, fit.forecasts, fit.pairs)
    bend = hessian(likelihood, found, fit.scales)
    at = np.concatenate([fit.x, [fit.scales[name] for name in names]])
    root = np.linalg.cholesky(np.linalg.inv(bend))
    random, wide, freedom, count = np.random.default_rng(7), 1.1, 8, 600
    size = len(at)
    z = random.normal(size=(count, size)) / np.sqrt(random.chisquare(freedom, count) / freedom)[:, None]
    from scipy.stats import multivariate_t

    proposal = multivariate_t(np.zeros(size), np.eye(size), df=freedom).logpdf(z)
    proposal -= np.log(np.diag(root)).sum() + size * np.log(wide)
    draws = at + wide * z @ root.T
    log = np.array([
        likelihood.log_posterior(x, dict(zip(names, scales, strict=True)), fit.pairs)
        for x, scales in zip(*np.split(draws, [len(fit.x)], axis=1), strict=True)
    ]) - proposal  # fmt: skip
    weight = np.exp(log - log.max())
    sampled = log.max() + np.log(weight.mean())
    assert weight.sum() ** 2 / (weight**2).sum() > 15  # enough draws count
    # Laplace leaves out what is skew in the scales: some tenths of a nat
    assert fit.evidence == pytest.approx(sampled, abs=1.5)
