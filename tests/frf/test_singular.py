"""An undamped pole is refused alike, whether it is asked for alone or in the middle of many lines."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.errors import SingularResponse


@pytest.mark.parametrize("lines", [1, 8, 101, 3001])
@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-15, 3e-15])
@pytest.mark.parametrize(("name", "posture"), [("fanuc_s360", "configuration_1"), ("six_axis", "work")])
def test_at_an_undamped_pole(name, posture, off, lines):
    plain = flexmodal.load(name)
    joints = {key: replace(joint, damping=0.0) for key, joint in plain.joints.items()}
    robot = replace(plain, joints=FrozenDict(joints))
    for frequency in robot.modes(posture).frequency * (1 + off):
        axis = np.linspace(0.5 * frequency, 1.5 * frequency, lines) if lines > 1 else np.array([frequency])
        axis[lines // 2] = frequency
        with pytest.raises(SingularResponse):
            robot.frf(posture, axis)
