"""The same diagnosis under other processors' arithmetic; `make arithmetic` asks more campaigns the same."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import write_campaign
from flexmodal.rig import simulate
from flexmodal.rig.robot_folder import write_robot

RUN = "import sys{}; from flexmodal.cli.main import main; main()"


def diagnosed(campaign, out, without="", **environment):
    command = [sys.executable, "-c", RUN.format(without), "diagnose", str(campaign), "--out", str(out)]
    command += ["--effects", "added_mass,joint_coupling", "--quiet"]
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    robot = flexmodal.load("fanuc_s360")
    names = ["configuration_1", "configuration_3", "configuration_7"]
    made = simulate(
        robot, postures=names, points=2, references=1, trials=2, peaks=(100.0,), seed=3, time=False,
        hide=["added_mass@link_3"],
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("campaign") / "campaign"
    write_campaign(made.campaign, folder)
    write_robot(made.robot, folder, made.plan.postures, made.plan.points)
    return folder


@pytest.mark.slow  # half a minute
def test_an_old_processor_without_numba_says_the_same(campaign, tmp_path):
    usual = diagnosed(campaign, tmp_path / "usual")
    old = diagnosed(
        campaign, tmp_path / "old", without="; sys.modules['numba'] = None",
        OPENBLAS_CORETYPE="Nehalem", NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4",
    )  # fmt: skip
    assert usual["verdict"]["effects"] == old["verdict"]["effects"] == [["added_mass", "link_3"]]
    assert usual["verdict"]["explained"] == old["verdict"]["explained"]
    for name, value in usual["gap"].items():
        np.testing.assert_allclose(old["gap"][name], value, rtol=0.01, err_msg=name)
    for one, other in zip(usual["steps"], old["steps"], strict=True):
        for name, value in one["parameters"].items():
            slack = 0.1 * one["uncertainty"].get(name, 0.0)
            np.testing.assert_allclose(other["parameters"][name], value, rtol=0.01, atol=slack, err_msg=name)
