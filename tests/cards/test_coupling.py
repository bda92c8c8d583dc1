"""Couplings, loss factors and where they hold: the optional keys of a card that a diagnosis writes."""

import pytest

from flexmodal.cards import CouplingCard, read_card
from flexmodal.errors import InvalidCard


def card_with(folder, *, joint="", top="", more=""):
    path = folder / "robot.toml"
    text = path.read_text(encoding="utf-8")
    text = text.replace("damping = 1.0", f"damping = 1.0\n{joint}", 1).replace(
        "format = 1", f"format = 1\n{top}", 1
    )
    path.write_text(text + more, encoding="utf-8")
    return path


def faults_of(path):
    with pytest.raises(InvalidCard) as caught:
        read_card(path)
    return list(caught.value.faults)


def test_they_are_read(folder):
    more = '[coupling."q1+bend"]\nstiffness = -40.5\n'
    card = read_card(card_with(folder, joint="loss_factor = 0.05", top="loss_frequency = 20", more=more))
    assert card.couplings == {"q1+bend": CouplingCard(("q1", "bend"), -40.5)}
    assert card.joints["q1"].loss_factor == 0.05
    assert card.joints["bend"].loss_factor == 0.0
    assert card.loss_frequency == 20.0


def test_they_may_be_absent(folder):
    card = read_card(folder / "robot.toml")
    assert (dict(card.couplings), card.loss_frequency, card.joints["q1"].loss_factor) == ({}, None, 0.0)


def test_joint_names_may_hold_plus_signs(folder):
    path = folder / "robot.toml"
    text = path.read_text(encoding="utf-8").replace("[joint.bend]", '[joint."a+b"]')
    path.write_text(text + '[coupling."q1+a+b"]\nstiffness = 1.0\n', encoding="utf-8")
    assert read_card(path).couplings["q1+a+b"].joints == ("q1", "a+b")


@pytest.mark.parametrize(
    ("given", "key", "found"),
    [
        ({"joint": "loss_factor = -0.1"}, "joint.q1.loss_factor", "-0.1"),
        ({"joint": "loss_factor = nan"}, "joint.q1.loss_factor", "nan"),
        ({"top": "loss_frequency = 0"}, "loss_frequency", "0"),
        ({"more": '[coupling."q1+bend"]\nstiffness = inf\n'}, "coupling.q1+bend.stiffness", "inf"),
        ({"more": '[coupling."q1+bend"]\nstifness = 2.0\n'}, "coupling.q1+bend.stifness", "an unknown key"),
        ({"more": '[coupling."q1+q9"]\nstiffness = 2.0\n'}, "coupling.q1+q9", 'the name "q1+q9"'),
        ({"more": '[coupling."q1+q1"]\nstiffness = 2.0\n'}, "coupling.q1+q1", 'the name "q1+q1"'),
        ({"more": "[coupling.q1]\nstiffness = 2.0\n"}, "coupling.q1", 'the name "q1"'),
        (
            {"more": '[coupling."q1+bend"]\nstiffness = 2.0\n[coupling."bend+q1"]\nstiffness = 2.0\n'},
            "coupling.bend+q1",
            "a pair that is coupled already",
        ),
        # √(1000 · 5000) = 2236
        ({"more": '[coupling."q1+bend"]\nstiffness = 2240.0\n'}, "coupling", "not positive definite"),
    ],
)
def test_faults(folder, given, key, found):
    faults = faults_of(card_with(folder, **given))
    assert any(fault.key == key and found in fault.found for fault in faults), faults


def test_just_definite(folder):
    more = '[coupling."q1+bend"]\nstiffness = -2230.0\n'
    assert read_card(card_with(folder, more=more)).couplings["q1+bend"].stiffness == -2230.0
