"""What data can tell, said before the fit, against what is known of the physics."""

import numpy as np
import pytest

from flexmodal.identification import Identifiability, RobotModel, build_identification
from flexmodal.structure import robot_space
from flexmodal.structure.parameter import Parameter, ParameterSpace


def test_frequencies_alone_do_not_tell_stiffness_from_mass(campaign, fanuc):
    space = robot_space(fanuc, ["stiffness", "damping", "mass"])
    problem = build_identification(campaign, fanuc, source="modes", space=space, use=["frequency"])
    exact = [one for one in problem.identifiability.combinations if one.exact]
    says = "stiffness, damping and mass scale together: the natural frequencies tell their ratios"
    assert says in [one.says for one in exact]
    assert says in problem.identifiability.verdict
    one = next(one for one in exact if one.says == says)
    assert set(one.parts) == set(space.names)
    np.testing.assert_allclose(list(one.parts.values()), 1.0, atol=1e-6)


def test_with_damping_held_the_scale_is_told_by_next_to_nothing(campaign, fanuc):
    """What fixes it then is how little damping moves |λ|."""
    space = robot_space(fanuc, ["stiffness", "mass"])
    problem = build_identification(campaign, fanuc, source="modes", space=space, use=["frequency"])
    found = problem.identifiability
    scale = np.ones(len(space)) / np.sqrt(len(space))
    told = scale @ found.information @ scale / np.trace(found.information)
    assert 0 < told < 1e-3
    assert any(one.left > 0.9 and not one.exact for one in found.combinations)


def test_the_direction_it_names_changes_no_frequency(campaign, fanuc):
    problem = build_identification(campaign, fanuc, source="modes", use=["frequency", "damping", "shape"])
    space, model = problem.space, RobotModel(fanuc, problem.space)
    exact = [one for one in problem.identifiability.combinations if one.exact]
    assert any("stiffness, damping and mass scale together" in one.says for one in exact)

    def frequencies(x):
        from flexmodal.structure.poles import poles

        return poles(model.structure_at(x, campaign.postures[0].q, [], [])).frequency

    card = frequencies(np.zeros(len(space)))
    for one in exact:
        x = np.array([1e-4 * one.parts.get(name, 0.0) for name in space.names])
        if len(one.parts) < 3 or "scale" in one.says:  # parts below a fifth are left out of the others
            np.testing.assert_allclose(frequencies(x), card, rtol=1e-7)


def test_frfs_tell_the_scale_but_not_mass_from_inertia_of_the_first_link(campaign, fanuc):
    """Of a link that turns about a fixed axis only its moment about that axis counts."""
    before = build_identification(campaign, fanuc).identifiability
    assert set(before.space.names) - set(before.identifiable) == {"mass.link_1", "inertia.link_1"}
    exact = [one for one in before.combinations if one.exact]
    assert [set(one.parts) for one in exact] == [{"mass.link_1", "inertia.link_1"}]
    assert "mass and inertia of link_1 trade off" in exact[0].says
    assert before.rank == len(before.space) - 1
    # moment about the axis: m c² + i k², the mass taking the inertia along
    link = fanuc.urdf.link_by_name["link_1"]
    steiner, own = link.mass * link.com[0] ** 2, link.inertia[1, 1]
    assert exact[0].parts["inertia.link_1"] / exact[0].parts["mass.link_1"] == pytest.approx(
        -(steiner + own) / own, rel=1e-3
    )


def test_expected_errors_are_those_that_a_fit_finds(campaign, fanuc):
    """Computed for independent lines; clusters make the errors of a fit larger, but not by decades."""
    problem = build_identification(campaign, fanuc)
    fitted = problem.evidence.fit()
    found = problem.evidence.uncertainty(fitted).deviation
    for name, error in zip(problem.space.names, found, strict=True):
        assert 0.1 < error / problem.identifiability.expected[name] < 15, name


def test_a_parameter_without_effect_is_named():
    space = ParameterSpace(tuple(Parameter(name, "", 1.0, 0.3) for name in ("stiffness.a", "stiffness.b")))
    found = Identifiability(space, np.diag([400.0, 0.0]), "these lines")
    assert found.identifiable == ("stiffness.a",)
    assert [one.says for one in found.combinations] == ["stiffness.b has no effect on these lines"]
    assert found.expected["stiffness.b"] == pytest.approx(0.3)
    assert found.expected["stiffness.a"] == pytest.approx(1 / np.sqrt(400 + 1 / 0.09))
    weak = Identifiability(space, np.diag([400.0, 1.0]), "these lines")
    assert weak.combinations[0].says == "stiffness.b has too little effect on these lines"
    assert not weak.combinations[0].exact
