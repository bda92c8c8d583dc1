"""What hangs on two links, across a joint: against the rig's loop of hose, and a string cut into pieces."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.effects.absorber_ways import directions
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.effects.hung_across import HUNG_ACROSS, clip_motions, places
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.assembly import Assembly

from .beside_rig import ours, seen_and_simulated, theirs

OWN = {
    "mass": 8.0, "frequency": 31.0, "damping_ratio": 0.03, "across_ratio": 0.6, "second_ratio": 300.0,
    "along": 0.7, "beside": 0.04, "angle": 0.3, "near_x": -0.05, "near_y": 0.08,
}  # fmt: skip
IN_SPACE = {"above": -0.02, "turn": 0.7, "roll": 0.4, "near_z": -0.03}


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def hung(request):
    """A short campaign in two postures, the rig's stand, a link with a joint, and values there."""
    postures = {"fanuc_s360": ["configuration_1", "configuration_6"], "six_axis": 2}
    context, observed, stand = seen_and_simulated(request.param, postures[request.param], points=4)
    values = OWN if context.normal is not None else {**OWN, **IN_SPACE}
    return context, observed, stand, places(context)[1], values


def test_it_is_the_loop_of_the_rig(hung):
    """Which has no second mode: here that is far above the band."""
    context, observed, stand, where, values = hung
    if context.normal is None:  # the second way of the rig's
        way, level, upright = directions(context, where, {**values, "roll": 0.0})
        second = across(way, None)[0]
        values = {**values, "roll": float(np.arctan2(second @ upright, second @ level))}
    found = ours(context, observed, HUNG_ACROSS, where, values)
    told = HUNG_ACROSS.physical(context, where, values)
    first = dict(zip(("dx", "dy", "dz"), directions(context, where, values)[0].tolist(), strict=True))
    of_rig = {
        **{name: told[name] for name in ("mass", "frequency", "damping_ratio", "x", "y", "z")},
        **{f"n{axis}": told[f"near_{axis}"] for axis in "xyz"},
        **first, "other": values["across_ratio"] ** 0.5,
    }  # fmt: skip
    other = theirs(observed, stand, "local_absorber", where, of_rig, "loop")
    off = np.abs(np.log(np.abs(found / other)))
    bare = ours(context, observed, HUNG_ACROSS, where, {**values, "mass": 1e-4 * context.arm_mass})
    assert np.abs(np.log(np.abs(bare / other))).max() > 0.05
    assert off.max() < 1e-3


def test_its_inertia_and_stiffness_are_those_of_a_string_in_pieces(hung):
    """By the rule of Gauss over its length, with both shapes."""
    context, _, _, where, values = hung
    every = np.arange(len(context.postures))
    none = np.zeros(len(every), dtype=int)
    blank = np.zeros((len(every), 2), dtype=int)
    placement = Placement(context, where, {**values, "second_ratio": 2.0}, every, none, blank, blank)
    assembly, bare = Assembly(context.stacked), Assembly(context.stacked)
    for one in (assembly, bare):
        HUNG_ACROSS.shape(one, placement)
    HUNG_ACROSS.act(assembly, placement)
    near, far = clip_motions(assembly, placement)
    ways = [assembly.axes(where) @ way for way in directions(context, where, values)]
    count = 1 if context.normal is not None else 2
    names = [name for name in assembly.coordinates if " hung" in name]
    point, weight = np.polynomial.legendre.leggauss(12)
    for place, part in zip((point + 1) / 2, weight / 2, strict=True):
        moved = (1 - place) * near + place * far
        for k, way in enumerate(ways):
            row = np.sum(way[..., :, None] * moved, axis=-2)
            if k < count:
                row = row + np.sin(np.pi * place) * assembly.row(names[k])
                row = row + np.sin(2 * np.pi * place) * assembly.row(names[count + k])
            bare.add_inertia(row, part * values["mass"])
    made, expected = (one.summed()["mass"] for one in (assembly, bare))
    np.testing.assert_allclose(made, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.some(2)
def test_it_sets_out_from_what_a_port_across_the_joint_tells(hung):
    """As the function of the mean of its clips swings: 8/π² of its mass, at its frequency."""
    context, _, _, where, values = hung
    frequency, count = np.linspace(*context.band, 200), 2 if context.normal is not None else 3
    omega, own = 2 * np.pi * frequency, 2 * np.pi * values["frequency"]
    spring = own**2 + 2j * values["damping_ratio"] * own * omega
    swung = 8 / np.pi**2 * values["mass"] * spring / (spring - omega**2)
    still = (1 - 8 / np.pi**2) * values["mass"]
    way = np.eye(count)[1]
    tensor = still * np.eye(count) + swung[:, None, None] * np.outer(way, way)
    row, column = np.triu_indices(count)
    value = np.concatenate([-(omega**2) * tensor[:, row, column].T, np.zeros((1, 200))])
    names = ("along", "beside", "above", "near_x", "near_y", "near_z")
    clips = {name: values[name] for name in names if name in values}
    free = FreeFunction(frequency, value, clips, np.zeros(3))
    told = HUNG_ACROSS.told(context, where, free)
    assert min(abs(np.log(one["mass"] / values["mass"])) for one in told) < 0.4
    for one in told:
        assert one["frequency"] == pytest.approx(values["frequency"], rel=0.02)
        assert {name: one[name] for name in clips} == clips
        known = {parameter.name for parameter in HUNG_ACROSS.parameters(context, where)}
        assert set(one) <= known
    mass = {"along": 0.5, "beside": 0.0}
    assert not HUNG_ACROSS.told(context, where, FreeFunction(frequency, value[:-1], mass, np.zeros(3)))
    level = catalogue()["local_absorber"]
    while level is not None:
        assert level.name == "local_absorber"
        assert bool(level.told and level.told(context, where, free)) is (level.shape is HUNG_ACROSS.shape)
        level = None if level.next_level is None else level.next_level.effect


def test_in_the_files_half_of_it_is_at_either_clip(hung):
    context, _, _, where, values = hung
    draft = Mock(spec=Draft, notes=[])
    HUNG_ACROSS.extend(draft, Placement.still(context, where, values))
    told = HUNG_ACROSS.physical(context, where, values)
    joint = next(one for one in context.robot.urdf.joints if one.child == where)
    (before, near), (after, far) = [one.args for one in draft.attach.call_args_list]
    assert (before, after) == (joint.parent, where)
    for body, ends in ((near, ("near_x", "near_y", "near_z")), (far, ("x", "y", "z"))):
        assert body.mass == values["mass"] / 2
        np.testing.assert_allclose(body.centre, [told[name] for name in ends])
    assert "swings, at 31 Hz" in draft.notes[0]
