"""What people see: the pixels of pages in a real browser.

Marks lie on top of everything and are not shaded, so their colours come out as they are; arms are shaded and
are counted by hue. The bounds on areas are wide: they tell a picture from a wrong one, not from a nicer one.
"""

import numpy as np
import pytest
from flexmodal_viewer import show_outcome, show_robot
from flexmodal_viewer.palette import EXTREME, FORCE, OPTIMISED, POINT, TARGET

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import Hold, Optimum, Outcome, PostureProblem, ReceptanceObjective, Start

PANEL = 340
"""Width of the panel beside the picture at 1200 pixels."""


def quiet(_):
    pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def fanuc_page(folder):
    robot = load("fanuc_s360")
    posture = robot.posture("configuration_1")
    out = folder / "fanuc.html"
    return show_robot(robot, posture, modes=True, frequency=9.0, live=False, out=out, announce=quiet)


@pytest.fixture(scope="module")
def outcome_page(folder):
    robot = load("six_link")
    best, start = robot.posture("e6_final"), robot.posture("start_3")
    objective = ReceptanceObjective((PointDirection("tool", "z"),), np.array([2.0]))
    value = objective.value(robot.at(start))
    x, _, z = robot.at(best).position("tool")
    outcome = Outcome(
        problem=PostureProblem(robot, objective, Hold.at(robot, (x, z))),
        optima=(Optimum(best, objective.value(robot.at(best)), 12),),
        compared=Start(start, value, 0.0, start, value),
        converged=True,
        starts=64,
        unbounded=0,
        method="newton",
    )
    return show_outcome(outcome, start=start, live=False, out=folder / "six_link.html", announce=quiet)


@pytest.fixture(scope="module")
def ur5_page(folder):
    robot = load("ur5", stiffness=2e4, damping=20.0)
    posture = robot.posture(dict(zip(robot.commanded, [0.0, -1.2, 1.4, -0.6, 1.57, 0.0], strict=True)))
    return show_robot(robot, posture, frequency=12.0, live=False, out=folder / "ur5.html", announce=quiet)


def exact(picture, colour):
    """Where a colour stands unshaded."""
    return np.all(np.abs(picture - 255 * np.array(colour)) < 12, axis=2)


def hue(picture, colour, *, slack=0.06, least=0.25):
    """Where a colour stands in any shade."""
    size = np.linalg.norm(picture, axis=2, keepdims=True) + 1e-9
    wanted = np.array(colour) / np.linalg.norm(colour)
    return (np.linalg.norm(picture / size - wanted, axis=2) < slack) & (size[..., 0] > 255 * least)


def clear_grey(picture):
    """Where something grey and translucent stands on white."""
    spread = picture.max(axis=2) - picture.min(axis=2)
    bright = picture.mean(axis=2)
    return (spread < 14) & (bright > 120) & (bright < 212)


def drawn(picture):
    """Where there is anything at all."""
    return np.any(picture < 236, axis=2)


def test_fanuc_stands_as_it_should(browser, fanuc_page):
    picture = browser.picture(fanuc_page, "#motion=0&phase=0.25")
    scene = picture[:, :-PANEL]
    assert 0.08 < drawn(scene).mean() < 0.5
    assert 300 < exact(scene, POINT).sum() < 8000
    assert 500 < exact(scene, FORCE).sum() < 8000
    assert picture[3, 3].tolist() == [255, 255, 255]  # light ground, which prints
    # The plinth stands lower left, the forearm (sand) is in the upper half and level.
    rows, columns = np.nonzero(hue(scene, (0.78, 0.66, 0.44)))
    assert rows.size > 3000
    assert rows.mean() < 0.5 * scene.shape[0]
    assert np.ptp(columns) > 2 * np.ptp(rows)
    dark_rows, dark_columns = np.nonzero(np.all(scene < 90, axis=2))
    assert dark_columns.mean() < 0.4 * scene.shape[1]
    assert dark_rows.mean() > rows.mean()


def test_panel_has_words(browser, fanuc_page):
    panel = browser.picture(fanuc_page, "#motion=0&phase=0")[:, -PANEL:]
    ink = np.all(panel < 110, axis=2)
    assert 0.01 < ink.mean() < 0.2


@pytest.mark.slow
def test_arm_moves_and_its_extreme_stays(browser, fanuc_page):
    first, second, again = (
        browser.picture(fanuc_page, f"#motion=0&phase={phase}")[:, :-PANEL] for phase in (0.1, 0.6, 0.1)
    )
    changed = np.any(np.abs(first - second) > 40, axis=2).mean()
    assert changed > 0.01
    assert np.any(np.abs(first - again) > 40, axis=2).mean() < 1e-4
    ghosts = hue(first, EXTREME, slack=0.25) & (first[..., 0] - first[..., 1] > 20)
    assert ghosts.sum() > 1500


@pytest.mark.slow
def test_each_mode_looks_different(browser, fanuc_page):
    pictures = [browser.picture(fanuc_page, f"#motion={mode}&phase=0")[:, :-PANEL] for mode in (1, 2)]
    assert np.any(np.abs(pictures[0] - pictures[1]) > 40, axis=2).mean() > 0.01


def test_it_plays_by_itself(browser, fanuc_page):
    document, _ = browser.document(fanuc_page)
    assert ">Pause<" in document  # what the button of a page that plays says


def test_outcome_shows_start_optimum_target_and_force(browser, outcome_page):
    scene = browser.picture(outcome_page)[:, :-PANEL]
    optimised = hue(scene, OPTIMISED)
    start = clear_grey(scene)
    assert 6000 < optimised.sum() < 60000
    assert 5000 < start.sum() < 80000
    assert 300 < exact(scene, TARGET).sum() < 4000
    assert 300 < exact(scene, FORCE).sum() < 6000
    # The optimum stands upright left of where the start bends to, and the target lies on it.
    assert np.nonzero(optimised)[1].mean() < np.nonzero(start)[1].mean()
    rows, columns = np.nonzero(exact(scene, TARGET))
    near = optimised[rows.min() - 40 : rows.max() + 40, columns.min() - 10 : columns.max() + 10]
    assert near.sum() > 500


@pytest.mark.slow
def test_start_swings_wider_than_the_optimum(browser, outcome_page):
    still, moved = (
        browser.picture(outcome_page, f"#motion=0&phase={phase}")[:, :-PANEL] for phase in (0.0, 0.5)
    )
    changed = np.any(np.abs(still - moved) > 30, axis=2)
    grey = changed & (clear_grey(still) | clear_grey(moved))
    blue = changed & (hue(still, OPTIMISED) ^ hue(moved, OPTIMISED))
    assert grey.sum() > 3 * blue.sum()


@pytest.mark.slow
def test_everything_is_inside_the_picture(browser, outcome_page, fanuc_page, ur5_page):
    for page in (outcome_page, fanuc_page, ur5_page):
        scene = browser.picture(page, "#motion=0&phase=0")[:, :-PANEL]
        edge = np.concatenate([scene[:8].reshape(-1, 3), scene[:, :2].reshape(-1, 3)])
        assert np.all(edge > 200)  # a line of the floor's grid at the most


@pytest.mark.slow
def test_arm_of_meshes(browser, ur5_page):
    scene = browser.picture(ur5_page, "#motion=0&phase=0.25")[:, :-PANEL]
    assert 0.1 < drawn(scene).mean() < 0.6
    assert np.all(scene < 70, axis=2).mean() > 0.02  # its black covers
    assert hue(scene, (64 / 255, 89 / 255, 104 / 255), slack=0.08).sum() > 1000  # and blue lids
    assert exact(scene, FORCE).sum() > 800


@pytest.mark.parametrize(
    "name",
    ["outcome_page", *(pytest.param(name, marks=pytest.mark.slow) for name in ("fanuc_page", "ur5_page"))],
)
def test_fits_a_telephone(browser, name, request):
    picture = browser.picture(request.getfixturevalue(name), "#phase=0", width=390, height=844)
    top, bottom = picture[:520], picture[530:]
    assert 0.05 < drawn(top).mean() < 0.6
    assert np.all(bottom < 110, axis=2).mean() > 0.01  # words begin under the picture
    assert np.all(picture[530:, -6:] > 225)  # and do not run over the edge


def test_names_do_not_run(browser, folder):
    attack = "</script><script>document.documentElement.dataset.ran = 1</script><img src=x onerror=alert(1)>"
    text = attack.replace("<", "&lt;").replace(">", "&gt;")
    path = folder / "hostile.urdf"
    path.write_text(
        f'<robot name="{text}"><link name="base"/><link name="{text}"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="{text}" type="continuous"><parent link="base"/><child link="{text}"/>'
        '<axis xyz="0 -1 0"/><origin xyz="0 0 1"/></joint></robot>'
    )
    robot = load(path, stiffness=1e4)
    out = folder / "hostile.html"
    show_robot(robot, robot.posture({}), modes=True, out=out, announce=quiet)
    document, _ = browser.document(out)
    assert "data-ran" not in document
    assert "<img" not in document
    assert "data-motion" in document


def test_no_errors_and_no_requests(browser, outcome_page, ur5_page):
    for page in (outcome_page, ur5_page):
        document, said = browser.document(page)
        assert "<canvas" in document
        lines = [line for line in said.splitlines() if "CONSOLE" in line]
        assert not [line for line in lines if "rror" in line or "Refused" in line or "violates" in line]
