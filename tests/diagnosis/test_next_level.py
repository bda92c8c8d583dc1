"""Wider laws under the same name: when they are tried, and that they are found from a narrower fit."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects import Context, catalogue, hinges
from flexmodal.diagnosis.effects.effect import Level
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import next_level
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.next_level import at_next_level
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection import frf_candidates, searches_beside, wider_laws
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED, LAW_LEAVES
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import observe, predict
from flexmodal.rig import simulate
from flexmodal.structure import robot_space

BASE = Mock(port="base", where="base", alike=(), has=lambda *key: key == ("base_flexibility", "base"))
"""What a look found."""
LINK = catalogue()["link_flexibility"]
FOUNDATION = catalogue()["base_flexibility"]
BLOCK = {
    "horizontal_stiffness": 8e6, "vertical_stiffness": 1.4e7, "tilt_stiffness": 4e6,
    "translation_damping": 6e3, "tilt_damping": 3e3, "aside": 0.1, "below": 0.5, "mass": 150.0,
    "mass_below": 0.3, "gyration": 0.3,
    "bolts_horizontal_ratio": 2.0, "bolts_vertical_ratio": 1.5, "bolts_tilt_ratio": 2.0,
}  # fmt: skip


@pytest.fixture(autouse=True)
def nothing_swept(monkeypatch):
    """Every law in every place has its own tests."""
    monkeypatch.setattr(FrfCandidates, "with_wider_laws", lambda self, before, found, look: found)


@pytest.fixture(scope="module")
def fits(context, observed):
    """A campaign with bolts that give, and the fit of a foundation without any."""
    root = Hypothesis(context, robot_space(context.robot))
    wide = root.and_also(Placed(FOUNDATION.next_level.effect, "base"))
    zero = np.zeros(len(root.space))
    value = predict(wide, wide.start(wide.placed[-1], BLOCK, zero), observed)
    seen = replace(observed, value=value)
    setup = Mock(
        spec=Setup, fitted=seen, observations=seen, held=np.zeros(len(seen), dtype=bool), context=context,
        effects=(), advance=Mock(),
    )  # fmt: skip
    narrow = root.and_also(Placed(FOUNDATION, "base"))
    begin = narrow.start(narrow.placed[-1], {k: v for k, v in BLOCK.items() if "bolts" not in k}, zero)
    return setup, zero, fitted_closely(setup, narrow, begin)


@pytest.mark.parametrize(
    ("beside", "straight", "followed", "coarse"),
    [
        ((), False, 3, 40 + 8 + 5),
        (("coulomb_friction", "q2"), False, 1, 8 + 3 + 2),
        (("coulomb_friction", "q2"), True, 1, 40 + 8 + 5),
    ],
)
def test_fewer_starts_are_followed_beside_torques_that_are_integrated(
    context, monkeypatch, beside, straight, followed, coarse
):
    root = Hypothesis(context, robot_space(context.robot))
    before = root.and_also(Placed(catalogue()[beside[0]], beside[1])) if beside else root
    narrow = before.and_also(Placed(FOUNDATION, "base"))
    x, taken = np.zeros(len(narrow.space)), []

    def fitted(one, floor, steps):
        taken.append(steps)
        return Candidate(one.hypothesis, one.x, float(len(taken)))

    look = Mock(spec=Look, fitted=fitted, integrates=lambda hypothesis: bool(beside) and not straight)
    look.started = lambda hypothesis, starts, floor, most: (
        [Candidate(hypothesis, x, 0.0) for x in starts[:1]] * most
    )
    close = Mock(return_value=[])
    monkeypatch.setattr(next_level, "seen_beside", lambda *given, by_force: look)
    monkeypatch.setattr(next_level, "tried_closely", close)
    setup = Mock(spec=Setup, context=context, advance=Mock(), fitted=None, held=np.zeros(1, dtype=bool))
    model = Mock(spec=FittedFrfs, hypothesis=narrow, x=x, predicted=np.zeros((1, 1)))
    none = np.zeros(len(before.space))
    assert at_next_level(setup, model, Mock(spec=SetOut, before=[none], told=lambda *given: []), Mock()) == []
    assert close.call_count == followed
    assert len(taken) == coarse


@pytest.mark.parametrize(
    ("costs", "fits"),
    [((5.0, 3.0, 2.0), 3), ((5.0, 5.001, 2.0), 2), ((5.0, 4.0, 4.001), 3), ((5.0, None, 2.0), 3)],
)
def test_no_further_start_is_followed_once_two_end_in_the_same_place(context, monkeypatch, costs, fits):
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(Placed(FOUNDATION, "base"))
    look = Mock(
        spec=Look, started=lambda given, tried, floor, most: [Mock(spec=Candidate, x=x) for x in tried]
    )
    look.fitted = lambda one, floor, steps: Mock(spec=Candidate, x=one.x, cost=one.x)
    left = iter(costs)

    def closely(setup, given, x):
        cost = next(left)
        return [] if cost is None else [Mock(spec=FittedFrfs, cost=cost)]

    monkeypatch.setattr(next_level, "tried_closely", closely)
    found = next_level._followed(
        Mock(spec=Setup, advance=Mock()),
        look,
        hypothesis,
        [1.0, 2.0, 3.0],
        lambda one: False,
        next_level.ROUNDS,
    )
    assert [one.cost for one in found] == [one for one in costs[:fits] if one is not None]


@pytest.mark.slow
def test_bolts_are_found_from_where_springs_alone_ended(fits):
    """An effect at its last level has no other."""
    setup, zero, narrow = fits
    assert over_noise(setup, narrow) > 2 * FLOOR_REACHED
    found = at_next_level(setup, narrow, SetOut([zero]), lambda one: over_noise(setup, one) < 0.1)
    best = min(found, key=lambda one: one.cost)
    assert at_next_level(setup, best, SetOut([zero]), lambda one: True) == []
    assert best.key == narrow.key
    assert over_noise(setup, best) < 0.1  # what was measured holds no noise
    values = best.hypothesis.space.values(best.x)
    for name, near in (
        ("mass", 0.05),
        ("bolts_horizontal_ratio", 0.05),
        ("bolts_tilt_ratio", 0.3),
    ):  # hardly seen
        assert values[f"base_flexibility@base.{name}"] == pytest.approx(BLOCK[name], rel=near)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("top", "true"),
    [
        (30.0, {"tube": 0.2, "turning_spread": 0.3}),
        (400.0, {"shift": 0.5, "spread": 0.1}),
    ],
)
def test_where_the_mass_of_a_link_is_and_where_it_gives_are_found_from_an_even_one(top, true):
    """A lump on two hinges anywhere; and a link on one hinge, where hinges are fixed for modes of its own."""
    robot = flexmodal.load("six_link")
    made = simulate(
        robot, postures=2, points=4, references=2, trials=2, seed=2, record_length=1.0, band=(2.0, top)
    )
    observed = observe(made.campaign)
    context = Context.of(robot, observed)
    link = next(one for one in context.links if (hinges.fixed(context, one) is None) == ("tube" in true))
    root = Hypothesis(context, robot_space(robot))
    wide = root.and_also(Placed(LINK.next_level.effect, link))
    zero = np.zeros(len(root.space))
    stiffness = 0.3 * hinges.stiffest(context, link)
    even = {"stiffness": stiffness, "damping": 3e-4 * stiffness}
    value = predict(wide, wide.start(wide.placed[-1], even | true, zero), observed)
    seen = replace(observed, value=value)
    setup = Mock(
        spec=Setup, fitted=seen, observations=seen, held=np.zeros(len(seen), dtype=bool), context=context,
        effects=(), advance=Mock(),
    )  # fmt: skip
    narrow = root.and_also(Placed(LINK, link))
    fitted = fitted_closely(setup, narrow, narrow.start(narrow.placed[-1], even, zero))
    found = at_next_level(setup, fitted, SetOut([zero]), lambda one: over_noise(setup, one) < 0.05)
    left = min(over_noise(setup, one) for one in found)
    assert left < 0.5 * over_noise(setup, fitted)


def test_a_link_that_sways_has_no_motion_without_inertia():
    """Sway turns hinges that bend as well: a coordinate of its own would leave one."""
    robot = flexmodal.load("six_link")
    made = simulate(
        robot, postures=2, points=4, references=2, trials=2, seed=2, record_length=1.0, band=(2.0, 300.0)
    )
    observed = observe(made.campaign)
    root = Hypothesis(Context.of(robot, observed), robot_space(robot))
    wide = root.and_also(Placed(LINK.next_level.effect, "link_1"))
    x = wide.start(wide.placed[-1], {"shift": 0.5, "sway": 0.1}, np.zeros(len(root.space)))
    seen, struck = (list(map(tuple, rows[:1].tolist())) for rows in (observed.response, observed.reference))
    for structure in wide.structures(x, seen, struck, slopes=False):
        scale = np.sqrt(np.diag(structure.mass))
        assert np.linalg.eigvalsh(structure.mass / np.outer(scale, scale)).min() > 1e-12
    ended, whole = predict(wide, x, observed), predict(wide, x, replace(observed, endless=True))
    assert 0 < np.abs(ended - whole).max() < np.abs(whole).max()


def test_each_effect_gets_its_wider_law_from_where_the_joint_fit_is(fits, monkeypatch):
    """The foundation came first, and is tried as the last; what has no wider law gets none."""
    setup, _, narrow = fits
    mass = Placed(replace(catalogue()["added_mass"], next_level=None), setup.context.links[-1])
    both = narrow.hypothesis.and_also(mass)
    x = both.start(mass, {"mass": 2.0}, narrow.x)
    misfit = replace(narrow.fitted.misfit, model=both)
    joint = replace(narrow, key=mass.key, hypothesis=both, fitted=replace(narrow.fitted, x=x, misfit=misfit))
    tried = []
    monkeypatch.setattr(wider_laws, "at_next_level", lambda setup, one, **more: tried.append(one) or [narrow])
    candidates = FrfCandidates(setup, narrow, with_force=False)
    assert candidates.wider(joint, [mass.key]) == []
    assert candidates.wider(joint, joint.hypothesis.keys) == [narrow]
    assert [one.key for one in tried] == [("base_flexibility", "base")]
    assert [one.hypothesis.keys for one in tried] == [(mass.key, ("base_flexibility", "base"))]
    assert tried[0].hypothesis.space.values(tried[0].x) == both.space.values(x)


@pytest.mark.parametrize(
    ("explains", "part", "met", "tried"),
    [(True, 1.1, True, True), (True, 0.9, True, True), (True, 1.1, False, False), (False, 1.1, True, False)],
)
def test_wider_laws_are_tried_where_the_law_is_to_blame(fits, monkeypatch, explains, part, met, tried):
    """At the place that explains everything, as long as no law takes half; else everywhere, later."""
    setup, _, narrow = fits
    wider = Mock(spec=FittedFrfs, key=narrow.key, cost=narrow.cost / 2)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda *given, **more: [wider])
    monkeypatch.setattr(wider_laws, "left", lambda *given: 1.0)
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    look = Mock(
        spec=Findings, explains=explains, found=(BASE,), needed=False, fitted=None,
        left=part * over_noise(setup, narrow) / LAW_LEAVES,
        met=lambda keys: {keys[0]: None} if met else {},
    )  # fmt: skip
    assert candidates.at_next_levels(root, [narrow], look) == [wider if tried else narrow]


@pytest.mark.parametrize(
    ("explains", "part", "tried"),
    [(True, 0.6, True), (True, 0.4, False), (False, 0.6, False)],
)
def test_a_law_that_takes_too_little_where_one_place_explains_it_is_widened(
    fits, monkeypatch, explains, part, tried
):
    """Where little is missing what it leaves may be near the noise, and yet most of what there was."""
    setup, _, narrow = fits
    wider = Mock(spec=FittedFrfs, key=narrow.key, cost=narrow.cost / 2)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda *given, **more: [wider])
    monkeypatch.setattr(wider_laws, "left", lambda *given: part)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    look = Mock(
        spec=Findings, explains=explains, found=(BASE,), needed=False, fitted=None,
        left=over_noise(setup, narrow), met=lambda keys: {keys[0]: None},
    )  # fmt: skip
    assert candidates.at_next_levels(root, [narrow], look) == [wider if tried else narrow]


@pytest.mark.parametrize(
    ("leaves", "without", "tried"),
    [
        (1.04, 1.0, set()),
        (1.07, 1.0, {("bearing", "q3")}),
        (1.9, 1.0, {("bearing", "q3")}),
        (3.0, 1.0, {("bearing", "q3"), ("joint", "q2")}),
        (3.0, 2.0, {("bearing", "q3")}),
    ],
)
def test_what_touches_a_place_is_tried_where_its_law_leaves_more_than_the_truth(
    fits, monkeypatch, leaves, without, tried
):
    """A place elsewhere only where a law leaves twice what the best function does, or twice the noise."""
    setup, _, narrow = fits
    asked = []
    monkeypatch.setattr(frf_candidates, "over_noise", lambda setup, one: leaves)
    monkeypatch.setattr(frf_candidates, "adjacent", lambda *given: frozenset({("bearing", "q3")}))
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.also_at = lambda before, number, found, ports: asked.append(set(ports)) or found
    place = Mock(port="joint", where="q2", judged=2.5)
    look = Mock(spec=Findings, found=(Mock(port="link", where="link_2"),), places=(place,), left=without)
    assert candidates._elsewhere(root, 0, [narrow], look) == [narrow]
    assert (asked or [set()]) == [tried]


@pytest.mark.parametrize(("enough", "levels"), [("first", 1), ("second", 2), ("none", 2)])
def test_a_wider_law_that_is_not_enough_gets_its_own_next_level(fits, monkeypatch, enough, levels):
    """From the nearest that it came to, until one is enough or there is no wider one."""
    setup, _, narrow = fits
    placed = narrow.hypothesis.placed[-1]
    second = replace(placed.effect, next_level=None, says="second")
    first = replace(
        placed.effect, next_level=Level(second, lambda context, where, values: [values]), says="first"
    )
    own = replace(placed.effect, next_level=Level(first, lambda context, where, values: [values]))
    begun = narrow.hypothesis.without(placed.key).and_also(Placed(own, placed.where))
    tried = []

    def followed(setup, seen, hypothesis, starts, is_enough, rounds):
        tried.append(hypothesis.placed[-1].effect.says)
        return [replace(narrow, hypothesis=hypothesis)]

    monkeypatch.setattr(next_level, "_followed", followed)
    found = at_next_level(
        setup, replace(narrow, hypothesis=begun), SetOut([]),
        lambda one: one.hypothesis.placed[-1].effect.says == enough,
    )  # fmt: skip
    assert list(dict.fromkeys(tried)) == ["first", "second"][:levels]
    assert {one.hypothesis.placed[-1].effect.says for one in found} == set(tried)


@pytest.mark.parametrize(
    ("alike", "leaves", "tried"),
    [((("link", "link_3"), ("bearing", "q3")), 1.0, True), ((("link", "link_3"),), 1.0, False),
     ((("link", "link_3"), ("bearing", "q3")), 3.0, False)],
)  # fmt: skip
def test_what_does_as_well_without_a_law_gets_its_wider_one_too(fits, monkeypatch, alike, leaves, tried):
    """A link that bends is enough; the joint that carries it, by its wider law, would be as well."""
    setup, _, narrow = fits
    link = Mock(spec=FittedFrfs, key=("link_flexibility", "link_3"), cost=narrow.cost)
    joint = Mock(spec=FittedFrfs, key=("bearing_flexibility", "q3"), cost=3 * narrow.cost)
    wider = Mock(spec=FittedFrfs, key=joint.key, cost=2 * narrow.cost)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda setup, one, **more: [wider][: one is joint])
    monkeypatch.setattr(wider_laws, "left", lambda setup, before, one: 0.1 if one is link else 0.9)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.is_enough = lambda model: model is link or (model is wider and leaves < 2)
    look = Mock(
        spec=Findings, explains=True, found=(Mock(port="link", classes=("spring",), alike=alike),),
        needed=False, fitted=None, left=1.0,
        met=lambda keys: {keys[0]: None} if keys[0] == link.key else {},
    )  # fmt: skip
    found = candidates.at_next_levels(root, [link, joint], look)
    assert found == ([link, wider] if tried else [link, joint])


@pytest.mark.parametrize(
    ("classes", "allowed", "tried"), [(("gain",), False, True), ((), False, False), (("gain",), True, False)]
)
def test_a_law_that_is_enough_stays_unless_the_curve_is_of_another_ones_class(
    fits, monkeypatch, classes, allowed, tried
):
    """As a lag where the sensitivity steps: the wider gain is tried, and evidence decides."""
    setup, _, narrow = fits
    lag = Mock(spec=FittedFrfs, key=("time_delay", "point_1"), cost=narrow.cost)
    gain = Mock(spec=FittedFrfs, key=("sensor_gain", "point_1"), cost=2 * narrow.cost)
    wider = Mock(spec=FittedFrfs, key=gain.key, cost=narrow.cost / 2)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda setup, one, **more: [wider][: one is gain])
    monkeypatch.setattr(wider_laws, "left", lambda setup, before, one: 0.1 if one is lag else 0.9)
    monkeypatch.setattr(wider_laws, "over_noise", lambda setup, one: 1.3 if one is lag else 5.0)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.is_enough = lambda model: model is lag
    look = Mock(
        spec=Findings, explains=True, found=(Mock(port="sensor", classes=classes, alike=()),), needed=False,
        fitted=None, left=0.6,
        met=lambda keys: {keys[0]: None} if allowed or keys[0] == gain.key else {},
    )  # fmt: skip
    found = candidates.at_next_levels(root, [lag, gain], look)
    assert found == ([wider, lag] if tried else [lag, gain])


@pytest.mark.parametrize(("port", "tried"), [("rod", True), ("coupling", False)])
def test_no_narrow_law_is_enough_where_only_wide_ones_do_what_was_found(fits, monkeypatch, port, tried):
    """Others may leave as little as the functions of a rod do while more is missing, but are none."""
    setup, _, narrow = fits
    wider = Mock(spec=FittedFrfs, key=narrow.key, cost=narrow.cost / 2)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda *given, **more: [wider])
    monkeypatch.setattr(wider_laws, "left", lambda *given: 0.4)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.is_enough = lambda model: False
    look = Mock(
        spec=Findings, explains=True, found=(Mock(port=port),), needed=False, fitted=None,
        left=over_noise(setup, narrow), met=lambda keys: {keys[0]: None},
    )  # fmt: skip
    assert candidates.at_next_levels(root, [narrow], look) == [wider if tried else narrow]


@pytest.mark.parametrize(("there", "searches"), [(True, 1), (False, 2)])
def test_what_sits_where_a_look_points_is_tried_though_others_leave_it_behind(
    fits, monkeypatch, there, searches
):
    setup, _, narrow = fits
    other = Mock(spec=FittedFrfs, key=("bearing_flexibility", "q1"), cost=narrow.cost / 2)
    asked = []

    def looked_for(*given, allowed, **more):
        asked.append(allowed)
        return [narrow] if there or len(asked) > 1 else [other]

    monkeypatch.setattr(searches_beside, "explanations", looked_for)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    look = Mock(spec=Findings, explains=True, found=(BASE,), needed=False, fitted=None)
    candidates.looks = Mock(one=look)
    found = candidates.pointed_at(root, 0, look, one_is_enough=False)
    assert found == ([narrow] if there else [other, narrow])
    assert len(asked) == searches
    assert there or (asked[1](*narrow.key) and not asked[1](*other.key))


@pytest.mark.parametrize(
    ("explains", "near", "tried"), [(False, True, True), (False, False, False), (True, True, False)]
)
def test_a_foundation_is_tried_where_the_first_bearing_may_be_it(fits, monkeypatch, explains, near, tried):
    """With its many functions free it may do worse than nothing on the postures held out."""
    setup, _, narrow = fits
    asked = []
    monkeypatch.setattr(
        searches_beside, "explanations", lambda *given, allowed, **more: asked.append(allowed) or [narrow]
    )
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=()), x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    look = Mock(
        spec=Findings, explains=explains, found=(BASE,), needed=False, fitted=None,
        worth_trying=lambda effect, where: where == "q1",
        is_near=lambda port, where: near and (port, where) == ("bearing", "q1"),
    )  # fmt: skip
    candidates.looks = Mock(one=look)
    candidates.pointed_at(root, 0, look, one_is_enough=False)
    assert asked[0]("base_flexibility", "base") is tried
    assert asked[0]("bearing_flexibility", "q1")
    assert not asked[0]("bearing_flexibility", "q2")


@pytest.mark.parametrize(
    ("part", "enough", "placed", "tried"),
    [
        (0.02, True, (), True),
        (0.05, True, (), False),
        (0.02, False, (), False),
        (0.02, True, ("one",), False),
    ],
)
def test_a_law_that_takes_all_but_a_little_is_widened_wherever_a_look_points(
    fits, monkeypatch, part, enough, placed, tried
):
    """If that leaves nothing: else something small may be missing besides, of which it would take a part."""
    setup, _, narrow = fits
    wider = Mock(spec=FittedFrfs, key=narrow.key, cost=narrow.cost / 2)
    monkeypatch.setattr(wider_laws, "at_next_level", lambda *given, **more: [wider])
    monkeypatch.setattr(wider_laws, "left", lambda *given: part)
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=placed, keys=placed), x=np.zeros(0))
    candidates = FrfCandidates(setup, narrow, with_force=False)
    candidates.is_enough = lambda model: model is wider and enough
    assert candidates.at_last(root, [narrow]) == [wider if tried else narrow]


@pytest.mark.parametrize(
    ("enough", "at", "tried"), [(False, True, True), (True, True, False), (True, False, True)]
)
def test_where_others_leave_less_than_what_was_found_all_starts_are_followed(
    fits, monkeypatch, enough, at, tried
):
    """Unless an effect leaves nothing in the place that was found; elsewhere it says nothing of that one."""
    setup, _, narrow = fits
    followed = []
    monkeypatch.setattr(wider_laws, "left", lambda *given: 1.0)
    monkeypatch.setattr(searches_beside, "explanations", lambda *given, **more: [narrow])
    monkeypatch.setattr(frf_candidates, "from_each_start", lambda *given: followed.extend(given[3]) or [])
    monkeypatch.setattr(frf_candidates, "pointed_to", lambda *given: [])
    monkeypatch.setattr(frf_candidates, "nearer", lambda *given: [("bearing_flexibility", "q1")])
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.is_enough = lambda model: enough
    look = Mock(
        spec=Findings, explains=True, found=(), needed=False, fitted=None, left=1e9, is_at=lambda keys: at
    )
    candidates.looks = Mock(one=look)
    candidates.at_places(root, 0, look, lambda one: False)
    assert followed == ([("bearing_flexibility", "q1")] if tried else [])


@pytest.mark.parametrize(
    ("one", "other", "plainer"),
    [
        (("servo_compliance", "q1"), ("base_flexibility", "base"), True),
        (("base_flexibility", "base"), ("servo_compliance", "q1"), False),
        (("local_absorber", "link_3"), ("local_absorber", "link_2"), False),
    ],
)
def test_a_plainer_effect_has_fewer_parameters(fits, one, other, plainer):
    setup, _, narrow = fits
    given = Mock(spec=Setup, effects=tuple(catalogue().values()), context=setup.context, advance=Mock())
    assert FrfCandidates(given, narrow, with_force=False)._is_plainer(one, other) is plainer


@pytest.mark.parametrize(
    ("key", "tried"), [(("servo_compliance", "q1"), True), (("local_absorber", "link_3"), False)]
)
def test_beside_what_is_enough_a_plainer_effect_at_the_place_found_is_followed(fits, monkeypatch, key, tried):
    """A foundation passed for a motor, whose fit had come to another minimum."""
    setup, _, narrow = fits
    enough, followed = replace(narrow, key=("sensor_gain", "tip")), []
    monkeypatch.setattr(wider_laws, "left", lambda *given: 0.0)
    monkeypatch.setattr(searches_beside, "explanations", lambda *given, **more: [enough])
    monkeypatch.setattr(frf_candidates, "from_each_start", lambda *given: followed.extend(given[3]) or [])
    monkeypatch.setattr(frf_candidates, "pointed_to", lambda *given: [key])
    given = Mock(
        spec=Setup, effects=tuple(catalogue().values()), context=setup.context, advance=Mock(),
        observations=setup.observations, held=setup.held,
    )  # fmt: skip
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(given, root, with_force=False)
    candidates.is_enough = lambda model: True
    look = Mock(
        spec=Findings, explains=True, found=(BASE,), needed=False, fitted=None, left=1e9,
        is_at=lambda keys: True,
    )  # fmt: skip
    candidates.looks = Mock(one=look)
    candidates.at_places(root, 0, look, lambda one: True)
    assert followed == ([key] if tried else [])


def test_no_law_is_widened_where_another_one_of_the_place_is_wide_enough(fits, monkeypatch):
    """A sensor that leans leaves three times as much there as one that reads too much."""
    setup, _, narrow = fits
    close = replace(narrow, key=("sensor_gain", "tip"), predicted=setup.observations.value)
    monkeypatch.setattr(searches_beside, "explanations", lambda *given, **more: [close, narrow])
    monkeypatch.setattr(wider_laws, "at_next_level", Mock(side_effect=AssertionError("widened")))
    monkeypatch.setattr(wider_laws, "left", lambda *given: 1.0)
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    candidates.is_enough = lambda model: False
    look = Mock(
        spec=Findings, explains=False, found=(BASE,), needed=False, fitted=None,
        left=0.1 * over_noise(setup, narrow), met=lambda keys: {keys[0]: None},
    )  # fmt: skip
    candidates.looks = Mock(one=look)
    assert candidates.at_places(root, 0, look, lambda one: False) == [close, narrow]


@pytest.mark.parametrize(
    ("explains", "port", "judged", "tried"),
    [
        (True, "body", 0.9, True),
        (True, "body", 1.1, False),
        (False, "body", 0.9, False),
        (True, "base", 1.1, True),
        (False, "base", 1.1, False),
    ],
)
def test_places_that_leave_less_than_the_law_are_tried(fits, monkeypatch, explains, port, judged, tried):
    """With free functions narrower than a law, a place may leave more than another and yet be right.

    Where it touches the one that a look points to, the look need not have come to it at all.
    """
    setup, _, narrow = fits
    other = Mock(spec=FittedFrfs, key=("bearing_flexibility", "q1"), cost=narrow.cost / 2)
    searched = []

    def looked_for(*given, allowed, **more):
        searched.append(allowed)
        return [other if allowed("bearing_flexibility", "q1") else narrow]

    monkeypatch.setattr(searches_beside, "explanations", looked_for)
    monkeypatch.setattr(frf_candidates, "from_each_start", lambda *given: [])
    monkeypatch.setattr(wider_laws, "left", lambda *given: 1.0)
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(setup, root, with_force=False)
    over = over_noise(setup, narrow)
    look = Mock(
        spec=Findings, explains=explains, needed=False,
        found=(Mock(port=port, where="base", alike=(), has=BASE.has),),
        fitted=None, left=0.5, met=lambda keys: {},
        places=(Mock(port="bearing", where="q1", judged=judged * over),),
        worth_trying=lambda effect, where: effect == "base_flexibility",
    )  # fmt: skip
    candidates.looks = Mock(one=look)
    found = candidates.at_places(root, 0, look, lambda one: False)
    assert found == ([other, narrow] if tried else [narrow])
    assert len(searched) == 1 + tried
    assert not tried or not searched[1]("bearing_flexibility", "q2")
    assert not tried or not searched[1](*narrow.key)
