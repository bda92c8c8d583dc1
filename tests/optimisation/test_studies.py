"""Studies: the files, each kind once, and what the page says of them."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidRequest
from flexmodal.optimisation import tune
from flexmodal.optimisation.studies import read_studies, run_study, shipped_studies

pytestmark = pytest.mark.usefixtures("types_unchecked", "descents_on_disk")

THESIS = Path(__file__).parents[1] / "data" / "thesis"


def rows(name):
    with (THESIS / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_optimisation_of_the_thesis_is_a_study_with_its_printed_numbers():
    studies = shipped_studies()
    for row in rows("six_link_optimisations"):
        table = row["table"]
        study = studies[
            table.lower().replace(".", "") if table[0] in "EF" else "table_" + table.replace(".", "_")
        ]
        kind = "stiffness_n_per_m" if row["objective"] == "stiffness" else "receptance_m_per_n"
        assert study.objective == row["objective"]
        assert study.printed_start == float(row[f"initial_{kind}"])
        assert study.printed_final == float(row[f"final_{kind}"])
        assert study.frequency == float(row["frequency_hz"] or 0)
        place = (float(row["location_x_m"]), float(row["location_y_m"]))
        assert study.hold == (place if row["position_controlled"] == "yes" else ())
        robot = flexmodal.load(study.robot)
        assert {study.start, study.printed} <= set(robot.postures)
    for number in ("1", "2", "3", "5", "6", "7"):
        study = studies[f"frequency_{number}"]
        printed = [row for row in rows("frequency_optimisation") if row["configuration"] == number]
        assert list(study.starts) == [float(row["initial_frequency_hz"]) for row in printed]
        assert list(study.printed_ends) == [float(row["final_frequency_hz"] or "inf") for row in printed]
        assert study.posture == f"configuration_{number}"
    assert all(len(study.says) > 5 for study in studies.values())


@pytest.mark.parametrize("name", ["e1", "e10", "f3"])
def test_postures(name):
    study = shipped_studies()[name]
    found = run_study(study)
    robot = flexmodal.load(study.robot)
    problem = study.problem(robot)
    assert found.start == pytest.approx(problem.objective.value(robot.at(study.start)), rel=1e-12)
    assert found.printed == pytest.approx(problem.objective.value(robot.at(study.printed)), rel=1e-12)
    assert found.better > 1.2
    if study.hold:
        many = run_study(study, starts=1500, seed=9)
        assert many.best == pytest.approx(found.best, rel=1e-6)
    else:
        assert found.best <= 1e-14  # the arm stands along the force


@pytest.mark.slow
def test_sweeps():
    """Against a scan, and the sums over poles against the numbers printed for 1000 Hz."""
    study = shipped_studies()["sweep_58"]
    found = run_study(study)
    robot = flexmodal.load(study.robot)
    angles = np.linspace(np.pi / 4, 3 * np.pi / 4, 721)
    scanned = [abs(robot.frf({"q1": a, "q2": -a}, [58.0]).value[0, 0, 0]) for a in angles]
    assert found.at == pytest.approx(angles[int(np.argmin(scanned))], abs=3e-3)
    assert found.best <= min(scanned)
    assert found.ends == pytest.approx((scanned[0], scanned[-1]))
    printed = shipped_studies()["sweep_1000"]
    assert run_study(printed).pole_sum == pytest.approx(printed.printed_ends, rel=2e-3)


def test_frequencies():
    """Where the slope leads, against walking down it in small steps."""
    study = shipped_studies()["frequency_3"]
    found = run_study(study)
    posed = flexmodal.load(study.robot).at(study.posture)
    grid = np.linspace(0.05, 200.0, 20_000)
    size = np.abs(posed.frf(grid).value[:, 0, 0])
    for start, end in zip(study.starts, found.ends, strict=True):
        place = int(np.argmin(np.abs(grid - start)))
        step = 1 if size[place + 1] < size[place] else -1
        while 0 < place < len(grid) - 1 and size[place + step] < size[place]:
            place += step
        expected = {0: 0.0, len(grid) - 1: np.inf}.get(place, grid[place])
        assert end == pytest.approx(expected, abs=0.02)
    assert found.minima == tuple(one.frequency for one in tune(posed, (0.0, 200.0)).minima)
    assert run_study(shipped_studies()["frequency_1"]).hops


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ["format", "robot", "study"]),
        ('format = 2\nrobot = "six_link"\n[study.a]\n', ["format: found 2", "study.a.title", "study.a.kind"]),
        (
            'format = 1\nrobot = "r"\n[study.a]\ntitle="t"\nsays="s"\nkind = "walk"\nhold = "x"\nfreq = 1\n',
            ["study.a.kind", "study.a.hold", "study.a.freq", "posture or sweep or frequency"],
        ),
        (
            'format = 1\nrobot = "r"\n[study.a]\ntitle="t"\nsays="s"\nkind="sweep"\n',
            ["a.family", "a.frequency"],
        ),
        ('format = 1\nrobot = "r"\nother = 1\n[study]\na = 1\n', ["other", "study.a"]),
        ("format = [", ["TOML"]),
    ],
)
def test_bad_files(tmp_path, text, says):
    file = tmp_path / "studies.toml"
    file.write_text(text)
    with pytest.raises(InvalidRequest) as caught:
        read_studies(file)
    for word in (*says, "studies.toml"):
        assert word in str(caught.value)


def test_command(capsys):
    from flexmodal.cli.main import main

    def run(*words):
        with pytest.raises(SystemExit) as left:
            main(["studies", *words])
        return left.value.code, *capsys.readouterr()

    status, out, _ = run("--json")
    assert status == 0
    assert {study["name"] for study in json.loads(out)["studies"]} == set(shipped_studies())
    status, out, _ = run("frequency_1", "sweep_8", "--json")
    first, second = json.loads(out)["studies"]
    assert status == 0
    assert first["ends"][-1] is None  # unbounded
    assert second["printed_ends"] == [5.31e-4, 4.92e-4]
    status, _, err = run("e99")
    assert status == 2
    assert "e99" in err
    assert "2.356" in run("sweep_8")[1]


def test_the_page_has_every_study():
    page = (Path(__file__).parents[2] / "docs" / "tables" / "studies.md").read_text(encoding="utf-8")
    for name in shipped_studies():
        assert f"| {name} |" in page
    assert "Missed" not in page
