"""Everything that goes wrong in a laboratory is found and named; of a clean test nothing is said."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import estimate_frfs
from flexmodal.errors import InvalidRequest
from flexmodal.rig.laboratory import MISHAPS, draw_mishaps, with_mishaps
from flexmodal.rig.laboratory.channels import high_passed
from flexmodal.soundness import check_soundness, without_coupling
from flexmodal.soundness.blows import force_corner, second_hit

CALLED = {"sensitivity": "scale", "AC coupled force": "AC coupling"}


@pytest.mark.parametrize("kind", [kind for kind in MISHAPS if kind != "axes swapped"])
def test_each_mishap_is_found_and_named(planar, fanuc, kind):
    spoilt, done = with_mishaps(planar, [kind], seed=3)
    assert [one.kind for one in done] == [kind]
    assert CALLED.get(kind, kind) in {one.kind for one in check_soundness(spoilt, fanuc)}


def test_two_axes_of_a_sensor(spatial, arm):
    spoilt, _ = with_mishaps(spatial, ["axes swapped"], seed=1)
    found = [one for one in check_soundness(spoilt, arm) if one.kind == "axes swapped"]
    assert len(found) == 1
    assert "from" in found[0].evidence


def test_nothing_is_said_of_clean_ones(planar, spatial, fanuc, arm):
    assert check_soundness(planar, fanuc) == ()
    assert check_soundness(spatial, arm) == ()
    assert check_soundness(planar) == ()


def test_nothing_is_said_of_frfs_alone_or_of_modes_alone(planar, fanuc):
    assert check_soundness(replace(planar, blows=()), fanuc) == ()
    bare = replace(planar, blows=(), frfs=replace(planar.frfs, coherence=None).select(trial=1))
    assert check_soundness(bare, fanuc) == ()  # nothing says how noisy it is: not compared


def test_three_at_once(planar, fanuc):
    spoilt, _ = with_mishaps(planar, ["sign", "postures exchanged", "drift"], seed=4)
    kinds = {one.kind for one in check_soundness(spoilt, fanuc)}
    assert {"sign", "postures exchanged", "drift"} <= kinds


def test_degrees_do_not_hide_what_else_is_wrong(planar, fanuc):
    spoilt, _ = with_mishaps(planar, ["degrees for radians", "joint sign"], seed=4)
    kinds = [one.kind for one in check_soundness(spoilt, fanuc)]
    assert kinds == ["degrees for radians", "joint sign"]


def test_a_finding_says_where_what_it_costs_and_what_to_do(planar, fanuc):
    point = planar.points[1]
    blows = tuple(
        replace(
            blow,
            response=blow.response
            * np.array([-1.0 if p == point.id else 1.0 for p, _ in blow.channels])[:, None],
        )
        for blow in planar.blows
    )
    spoilt = replace(planar, blows=blows, frfs=None)
    found = [one for one in check_soundness(spoilt, fanuc) if one.kind == "sign"]
    assert [one.where for one in found] == [f"{point.name}:+z in all postures"]
    assert "takes it for stiffness" in found[0].cost
    assert "turn the sense" in found[0].remedy
    assert found[0].kind in str(found[0])


def test_what_was_done_to_a_campaign_is_what_it_says(planar):
    """Exchanged angles are exchanged, and nothing else is touched."""
    spoilt, (done,) = with_mishaps(planar, ["postures exchanged"], seed=5)
    first, second = done.where.split(" and ")
    q = {one.name: one.q for one in planar.postures}
    other = {one.name: one.q for one in spoilt.postures}
    assert (other[first], other[second]) == (q[second], q[first])
    np.testing.assert_array_equal(spoilt.frfs.value, planar.frfs.value)
    scaled, _ = with_mishaps(planar, ["scale"], seed=5)
    np.testing.assert_allclose(scaled.frfs.value, planar.frfs.value / 9.80665, rtol=1e-9)
    one, other = (with_mishaps(planar, ["drift"], seed=9) for _ in range(2))
    assert one[1] == other[1]


def test_mishaps_without_a_place_are_left_out_and_unknown_ones_refused(planar):
    assert with_mishaps(planar, ["axes swapped"], seed=0)[1] == ()
    with pytest.raises(InvalidRequest, match="fire"):
        with_mishaps(planar, ["fire"], seed=0)
    with pytest.raises(InvalidRequest, match="no blows"):
        with_mishaps(replace(planar, blows=()), ["sign"], seed=0)
    assert len(set(draw_mishaps(3, 1))) == 3


def test_a_rebound_that_the_force_holds_is_harmless_and_one_that_cancels_lines_is_not(planar):
    def again(part, later):
        blow = planar.blows[0]
        shift = round(later / blow.step)
        force, response = np.zeros_like(blow.force), np.zeros_like(blow.response)
        force[shift:], response[:, shift:] = blow.force[:-shift], blow.response[:, :-shift]
        return replace(blow, force=blow.force + part * force, response=blow.response + part * response)

    for part, harmless in ((0.06, True), (0.95, False)):
        blow = again(part, 0.03)
        size, after = second_hit(blow)
        assert size == pytest.approx(part, rel=0.1)
        assert after == pytest.approx(0.03, abs=0.003)
        told = check_soundness(replace(planar, blows=(blow,), frfs=None))
        assert [one.harmless for one in told if one.kind == "double hit"] == [harmless]
    assert second_hit(planar.blows[0]) is None


@pytest.mark.parametrize("corner", [1.0, 3.0])
def test_the_corner_of_a_coupled_force_is_found(planar, corner):
    blow = planar.blows[0]
    spoilt = replace(blow, force=high_passed(blow.force, corner, blow.step))
    assert force_corner(spoilt) == pytest.approx(corner, rel=0.25)
    assert force_corner(blow) is None


def test_a_corner_is_taken_out(planar):
    """High-passed in time, put right in frequency: the FRFs of the untouched blows come back."""
    corner, place = 3.0, (planar.points[0].id, 3)
    blows = []
    for blow in planar.blows:
        response = blow.response.copy()
        for row, channel in enumerate(blow.channels):
            if channel == place:
                response[row] = high_passed(response[row], corner, blow.step)
        blows.append(replace(blow, response=response))
    spoilt = estimate_frfs(replace(planar, blows=tuple(blows), frfs=None))
    mended = without_coupling(spoilt, corner, response=place)
    low = (spoilt.frequency >= 3) & (spoilt.frequency <= 30)
    rows = np.flatnonzero(np.all(spoilt.response == place, axis=1))
    true = planar.frfs.value[rows][:, low]
    before = np.abs(np.log(spoilt.value[rows][:, low] / true)).mean()
    after = np.abs(np.log(mended.value[rows][:, low] / true)).mean()
    assert after < 0.15 * before
    others = np.flatnonzero(~np.all(spoilt.response == place, axis=1))
    np.testing.assert_array_equal(mended.value[others], spoilt.value[others])
    forced = without_coupling(without_coupling(spoilt, corner), corner, force=True)
    np.testing.assert_allclose(forced.value[:, 1:], spoilt.value[:, 1:], rtol=1e-12)
    with pytest.raises(InvalidRequest, match="above 0"):
        without_coupling(spoilt, 0.0)
