"""Forms of effects: listed once, passive, repeatable, and not to be told from the campaign's folder."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.rig import (
    EFFECTS,
    FORM_SETS,
    FORMS,
    Hide,
    hide_places,
    simulate,
)
from flexmodal.rig.effects.effect import OWN
from flexmodal.rig.forms import find
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.severity import height, limit, noise_floor
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plant.build import build

SMALL = {"postures": 2, "points": 2, "references": 1, "trials": 2, "averages": 1, "record_length": 0.5}
OTHERS = [effect.key for forms in FORMS.values() for effect in forms.values() if effect.form != OWN]
ELSEWHERE = {"local_absorber:wire_rope"}
"""Forms whose law is no joint's; its own test holds it to the same."""
IN_JOINTS = [key for key in OTHERS if not find(*key.split(":")).linear and key not in ELSEWHERE]
WHOLE = {"sensor_gain:inverted", "sensor_misalignment:swapped"}
"""Forms of which there is no weaker degree."""
ACTIVE = {"servo_compliance"}
"""Effects with a motor, which may do work."""
CONTROLLED = {"joint_coupling:cross_coupled"}
"""Forms with one."""


@pytest.fixture(scope="module")
def arms():
    """A planar and a spatial arm, with the stands of a clean campaign."""
    found = {}
    for name in ("fanuc_s360", "six_axis"):
        robot = flexmodal.load(name)
        found[name] = simulate(robot, **SMALL, noise=0.0, time=False).stand
    return found


@pytest.fixture(scope="module")
def plain(arms, tmp_path_factory):
    """The folder of a campaign with nothing hidden."""
    folder = tmp_path_factory.mktemp("plain") / "test"
    simulate(arms["six_axis"].robot, **SMALL, seed=3, time=False).write(folder)
    return folder


def drawn(stand, key: str, seed: int = 1):
    """A form as it is drawn at its first place; None where it has none."""
    from flexmodal.rig.effects import Site

    effect = find(*key.split(":"))
    places = effect.places(stand.robot, stand.plan.points)
    if not places:
        return None
    where = places[seed % len(places)]
    return effect, Site(stand, where, effect.draw(stand, where, np.random.default_rng(seed)))


def test_every_form_is_in_one_table():
    listed = [f"{name}:{form}" for table in FORM_SETS.values() for name in table for form in table[name]]
    assert sorted(listed) == sorted(OTHERS)
    assert all(find(*key.split(":")).source for key in OTHERS)


def test_the_page_lists_every_form():
    page = (Path(__file__).parents[2] / "docs" / "rig.md").read_text(encoding="utf-8")
    words = {which: "looked at" if which == "looked" else which for which in FORM_SETS}
    for which, table in FORM_SETS.items():
        for name, forms in table.items():
            for form in forms:
                effect = FORMS[name][form]
                row = f"| `{name}` | `{form}` | {words[which]} | {effect.says} | {effect.source} |"
                assert row in page, f"to be added to docs/rig.md: {row}"
    assert sum(page.count(f"| {word} |") for word in words.values()) == len(OTHERS)


ONE_EACH = {key.split(":")[0]: key for key in OTHERS}
"""Of each effect the last form."""
SLOW = set(OTHERS) - set(ONE_EACH.values())
"""The others, which `make slow` puts in."""


@pytest.mark.parametrize(
    "key", [pytest.param(key, marks=[pytest.mark.slow] if key in SLOW else []) for key in OTHERS]
)
def test_a_form_is_put_in_and_named_in_the_truth_alone(key, arms, plain, tmp_path):
    name, form = key.split(":")
    robot = arms["six_axis"].robot
    result = simulate(robot, **SMALL, hide=[key], seed=3, time=False)
    assert np.all(np.isfinite(result.campaign.frfs.value))
    nothing = read_campaign(plain).frfs.value
    assert not np.allclose(result.campaign.frfs.value, nothing, rtol=1e-6, atol=0)
    result.write(tmp_path / "test")
    truth = tomllib.loads((tmp_path / "test.truth.toml").read_text(encoding="utf-8"))
    assert (truth["effect"][0]["effect"], truth["effect"][0]["form"]) == (name, form)
    for file in sorted(plain.rglob("*")):
        there = tmp_path / "test" / file.relative_to(plain)
        if file.is_file() and file.suffix != ".uff":
            assert there.read_bytes() == file.read_bytes()
        assert file.is_dir() or there.stat().st_size == file.stat().st_size
    assert len(list((tmp_path / "test").rglob("*"))) == len(list(plain.rglob("*")))


@pytest.mark.some(3)
@pytest.mark.parametrize("key", ONE_EACH.values())
def test_a_form_is_the_same_however_it_is_written_and_each_time(key, arms):
    name, form = key.split(":")
    robot = arms["six_axis"].robot
    one, other = (
        simulate(robot, **SMALL, hide=[hide], seed=3, time=False) for hide in (key, Hide(name, form=form))
    )
    np.testing.assert_array_equal(one.campaign.frfs.value, other.campaign.frfs.value)


def test_the_own_form_is_the_one_without_a_name(arms):
    robot = arms["fanuc_s360"].robot
    one, other = (simulate(robot, **SMALL, hide=[h], seed=2) for h in ("added_mass", "added_mass:own"))
    np.testing.assert_array_equal(one.campaign.frfs.value, other.campaign.frfs.value)
    assert one.truth.effects[0].form == OWN


def test_an_unknown_form_is_named_with_those_there_are(arms):
    with pytest.raises(InvalidRequest, match="unknown form 'rubber'; allowed: own, hinge, tapered"):
        simulate(arms["fanuc_s360"].robot, **SMALL, hide=["link_flexibility:rubber"])


@pytest.mark.some(4)
@pytest.mark.parametrize("key", OTHERS)
@pytest.mark.parametrize("arm", ["fanuc_s360", "six_axis"])
def test_the_highest_severity_of_a_form_is_allowed(key, arm, arms):
    for seed in range(50):
        found = drawn(arms[arm], key, seed)
        if found is None:
            return
        effect, site = found
        assert effect.check(site.parameters) is None, site.parameters
        most = effect.scaled(site.parameters, limit(effect, site.parameters))
        assert effect.check(most) is None, most


@pytest.fixture(scope="module")
def small_floor(arms):
    """Lines and postures of the planar arm to judge a height on."""
    return noise_floor(arms["fanuc_s360"], Conduct(noise=0.02))


@pytest.mark.some(4)
@pytest.mark.parametrize("key", [key for key in OTHERS if key not in WHOLE])
def test_a_form_of_no_severity_is_as_good_as_nothing(key, arms, small_floor):
    stand = arms["fanuc_s360"]
    found = drawn(stand, key)
    if found is None:
        return
    effect, site = found
    scaled = effect.scaled(site.parameters, 1e-7)
    assert height(stand, [(effect, replace(site, parameters=scaled))], small_floor) < 0.05


@pytest.mark.some(4)
@pytest.mark.parametrize("key", [key for key in OTHERS if find(*key.split(":")).sense is None])
@pytest.mark.parametrize("arm", ["fanuc_s360", "six_axis"])
def test_a_form_dies_down_and_gives_no_work(key, arm, arms):
    """Small motions: poles on the left, and no force along any direction ever puts in negative power."""
    for seed in range(4):
        found = drawn(arms[arm], key, seed)
        if found is None:
            return
        plant = build(arms[arm], arms[arm].plan.postures[0], [found])
        assert np.linalg.eigvalsh(plant.mass)[0] > 0
        assert np.linalg.eigvals(plant.state_matrix).real.max() < 0
        if key.split(":")[0] in ACTIVE or key in CONTROLLED:
            continue
        frequency = np.geomspace(0.1, 5000.0, 200)
        row = np.eye(plant.dof)
        mobility = plant.inertance(row, row, frequency) / (2j * np.pi * frequency)[:, None, None]
        power = np.linalg.eigvalsh(mobility + mobility.conj().swapaxes(1, 2))
        assert power.min() > -1e-9 * np.abs(mobility).max()


@pytest.mark.some(3)
@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 5), marks=pytest.mark.slow)], ids=str)
@pytest.mark.parametrize("key", IN_JOINTS)
def test_torques_of_a_joint_never_give_more_work_than_they_took(key, seeds, arms):
    """Along random paths from rest, spring and damper included: ∫ τ du ≥ 0 at every moment."""
    stand = arms["fanuc_s360"]
    random = np.random.default_rng(7)
    for seed in seeds:
        effect, site = drawn(stand, key, seed)
        plant = build(stand, stand.plan.postures[0], [(effect, site)])
        plain = build(stand, stand.plan.postures[0], [])
        row = plain.coordinates.index(site.where)
        added = plant.damping[row, row] - plain.damping[row, row]
        step, size = 2e-5, 2 * stand.deflection[site.where][1]
        time = np.arange(10000) * step
        waves = random.uniform(5, 100, 6), random.uniform(0, 2 * np.pi, 6), random.uniform(0, 1, 6)
        path = sum(a * (np.sin(2 * np.pi * f * time + p) - np.sin(p)) for f, p, a in zip(*waves, strict=True))
        path = size * path / np.abs(path).max()
        torque = stand.true.stiffness[site.where] * path + added * np.gradient(path, step)
        for element in plant.elements:
            law, numbers, memory = LAWS[element.kind], np.array(element.parameters), np.zeros(1)
            for n in range(1, len(path)):
                old, new = path[n - 1 : n], path[n : n + 1]
                pull, memory = law(numbers, old, new, (new - old) / step, memory)
                torque[n] += pull[0]
        work = np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2 * np.diff(path))])
        assert work.min() > -1e-4 * work.max()


def test_places_of_forms_are_places_of_their_effect(arms):
    for stand in arms.values():
        places = hide_places(stand.robot, points=2)
        for key in OTHERS:
            name, form = key.split(":")
            own = set(places[name])
            assert set(FORMS[name][form].places(stand.robot, stand.plan.points)) <= own
    assert set(FORMS) == set(EFFECTS)
