"""The cards against the tables of the thesis, and their models against what is known to come out of them."""

import csv
import math
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexmodal.cards import RobotCard, Urdf, read_card, read_urdf, shipped_cards

TABLES = Path(__file__).parent.parent / "data" / "thesis"
JOINTS = {"1": "q1", "2.1": "q2", "2.2": "rho", "3": "q3"}


def table(name: str) -> list[dict[str, str]]:
    with (TABLES / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def load(name: str) -> tuple[RobotCard, Urdf]:
    card = read_card(shipped_cards()[name])
    return card, read_urdf(card.urdf)


@pytest.mark.parametrize(("name", "number"), [("fanuc_s360", "2.9"), ("fanuc_s360_table_2_8", "2.8")])
def test_dynamic_parameters(name, number):
    card, urdf = load(name)
    rows = {JOINTS[row["link"]]: row for row in table("dynamic_parameters") if row["table"] == number}
    assert set(rows) == set(card.joints) == set(urdf.movable_joints)
    assert card.pseudo_joints == ("rho",)
    for joint, row in rows.items():
        link = urdf.link_by_name[urdf.joint_by_name[joint].child]
        assert card.joints[joint].stiffness == float(row["stiffness_n_m_per_rad"])
        assert card.joints[joint].damping == float(row["damping_n_m_s_per_rad"])
        assert link.mass == float(row["mass_kg"])
        assert link.inertia[1, 1] == float(row["inertia_kg_m2"])


@pytest.mark.parametrize("name", ["fanuc_s360", "fanuc_s360_table_2_8", "fanuc_s360_rigid_link"])
def test_configurations(name):
    card, _ = load(name)
    rows = table("configurations")
    assert set(card.postures) == {f"configuration_{row['configuration']}" for row in rows}
    for row in rows:
        posture = card.postures[f"configuration_{row['configuration']}"]
        assert set(posture) == {"q1", "q2", "q3"}
        for joint, angle in posture.items():
            assert angle == math.radians(float(row[f"{joint}_deg"]))
            assert angle == pytest.approx(float(row[f"{joint}_rad"]), abs=5e-7)  # six digits are printed
    family = card.families["second_link_horizontal"]
    assert (family.parameter, family.start, family.stop) == ("q1", math.pi / 4, 3 * math.pi / 4)
    assert family.follow == {"q2": -1.0}


def test_six_link_parameters():
    card, urdf = load("six_link")
    for row in table("six_link_parameters"):
        joint, link = card.joints[f"q{row['link']}"], urdf.link_by_name[f"link_{row['link']}"]
        assert joint.stiffness == float(row["stiffness_reproducing_n_m_per_rad"])
        assert joint.stiffness == 10 * float(row["stiffness_printed_n_m_per_rad"])
        assert joint.damping == float(row["damping_n_m_s_per_rad"])
        assert link.mass == float(row["mass_kg"])
        assert link.inertia[1, 1] == float(row["inertia_kg_m2"])
        assert link.com[0] == 0.5


def test_six_link_postures():
    card, _ = load("six_link")
    printed: dict[str, dict[str, float]] = {}
    for row in table("six_link_joint_angles"):
        number = row["table"].lower()
        name = f"table_{number.replace('.', '_')}" if number[0] == "3" else number.replace(".", "")
        printed.setdefault(f"{name}_{row['stage']}", {})[f"q{row['joint']}"] = float(row["angle_rad"])
    finals = {name: posture for name, posture in printed.items() if name.endswith("_final")}
    assert len(finals) == 20
    assert {name: dict(card.postures[name]) for name in finals} == finals
    assert card.postures["start_2"] == printed["table_3_9_initial"]
    assert card.postures["start_3"] == printed["table_3_8_initial"]
    start = card.postures["start_1"]
    assert start == {"q1": math.pi / 2} | {f"q{k}": math.pi / 6 for k in range(2, 7)}
    for joint, angle in printed["e1_initial"].items():
        assert angle == pytest.approx(start[joint], abs=0.005)  # two decimals are printed
    assert set(card.postures) == {"start_1", "start_2", "start_3", *finals}


class Posed:
    """Mass, stiffness and damping of a card at one of its postures, gravity left out."""

    def __init__(self, name: str, posture: str) -> None:
        card, urdf = load(name)
        self.model = pin.buildModelFromXML(urdf.text)
        self.data = self.model.createData()
        names = list(self.model.names)[1:]
        self.q = np.array([card.postures[posture].get(joint, 0.0) for joint in names])
        self.mass = pin.crba(self.model, self.data, self.q).copy()
        self.stiffness = np.diag([card.joints[joint].stiffness for joint in names])
        self.damping = np.diag([card.joints[joint].damping for joint in names])

    def frequencies(self) -> np.ndarray:
        """|λ| / 2π of the poles with positive frequency [Hz], ascending."""
        n = len(self.q)
        lower = -np.linalg.solve(self.mass, np.hstack([self.stiffness, self.damping]))
        poles = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
        return np.sort(np.abs(poles[poles.imag > 0])) / (2 * np.pi)

    def row(self, frame: str) -> np.ndarray:
        """The vertical row of the Jacobian of a frame."""
        index = self.model.getFrameId(frame)
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.computeFrameJacobian(self.model, self.data, self.q, index, world)[2]


def measured(number: str, configuration: int) -> list[dict[str, str]]:
    """Rows of Appendix C for a configuration, beside what Table `number` gave with the four round lengths."""
    return [
        row
        for row in table("fanuc_frequency_check")
        if row["lengths"].startswith("given")
        and row["table"] == number
        and row["configuration"] == str(configuration)
    ]


@pytest.mark.parametrize("configuration", [1, 2, 6, 7])
def test_frequencies_of_table_2_9(configuration):
    found = Posed("fanuc_s360", f"configuration_{configuration}").frequencies()
    rows = measured("2.9", configuration)
    np.testing.assert_allclose(
        found, [float(row["computed_natural_frequency_hz"]) for row in rows], atol=0.01
    )
    np.testing.assert_allclose(found, [float(row["measured_location1_hz"]) for row in rows], rtol=0.035)


@pytest.mark.parametrize("configuration", [1, 7])
def test_frequencies_of_table_2_8(configuration):
    found = Posed("fanuc_s360_table_2_8", f"configuration_{configuration}").frequencies()
    rows = measured("2.8", configuration)
    # the lengths are rounded to centimetres, which adds a tenth to the 1.8 % of the best fit
    np.testing.assert_allclose(found, [float(row["measured_location1_hz"]) for row in rows], rtol=0.02)


def test_rigid_link_is_the_union_of_its_parts():
    """A pseudo-joint that does not move leaves the rigid-link robot: kinetic energy agrees."""
    soft, rigid = Posed("fanuc_s360", "configuration_2"), Posed("fanuc_s360_rigid_link", "configuration_2")
    commanded = [0, 1, 3]
    np.testing.assert_allclose(soft.mass[np.ix_(commanded, commanded)], rigid.mass, rtol=1e-12)
    np.testing.assert_array_equal(soft.stiffness[commanded][:, commanded], rigid.stiffness)
    np.testing.assert_allclose(soft.row("tool")[commanded], rigid.row("tool"), atol=1e-12)


@pytest.mark.parametrize("posture", ["configuration_1", "configuration_7"])
def test_points_sit_at_the_same_place_with_and_without_the_pseudo_joint(posture):
    places = []
    for name in ("fanuc_s360", "fanuc_s360_rigid_link"):
        posed, (card, _) = Posed(name, posture), load(name)
        pin.framesForwardKinematics(posed.model, posed.data, posed.q)
        places.append(
            {
                point: posed.data.oMf[posed.model.getFrameId(at.link)].act(np.array(at.xyz))
                for point, at in card.points.items()
            }
        )
    assert places[0].keys() == places[1].keys()
    for point, place in places[0].items():
        np.testing.assert_allclose(place, places[1][point], atol=1e-12)


def test_static_receptance_of_the_six_link_arm():
    posed = Posed("six_link", "start_3")
    row = posed.row("tool")
    assert row @ np.linalg.solve(posed.stiffness, row) == pytest.approx(
        6.85e-4, abs=5e-7
    )  # printed in Table E.3


@pytest.mark.parametrize(
    ("posture", "place", "within"),
    [("start_1", (-3.73, 1.00), 0.01), ("e10_final", (-3.5, 1), 0.06), ("f2_final", (-2, 2), 0.06)],
)
def test_end_points_of_the_six_link_arm(posture, place, within):
    posed = Posed("six_link", posture)
    pin.framesForwardKinematics(posed.model, posed.data, posed.q)
    x, y, z = posed.data.oMf[posed.model.getFrameId("tool")].translation
    assert (x, z) == pytest.approx(place, abs=within)  # two decimals are printed for each of six angles
    assert y == pytest.approx(0, abs=1e-12)
