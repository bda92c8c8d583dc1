"""What people read: tables with units, and where files went."""

import pytest


def test_robots_lists_joints_points_postures_and_example_arms(cli):
    ran = cli("robots")
    assert (ran.status, ran.err) == (0, "")
    for word in ("fanuc_s360", "q1 q2 (rho) q3", "second_link_horizontal", "location_6", "configuration_7"):
        assert word in ran.out
    assert "panda" in ran.out.splitlines()[-1]


def test_frf(cli):
    ran = cli("frf", "fanuc_s360", "--posture", "configuration_1", "--frequencies", "5")
    assert (ran.status, ran.err) == (0, "")
    assert "amplitude [m/N]" in ran.out
    assert "phase [°]" in ran.out
    assert "tool:+z per tool:+z" in " ".join(ran.out.split())


def test_a_long_frf_is_thinned_and_says_so(cli):
    ran = cli("frf", "fanuc_s360", "--posture", "configuration_1", "--frequencies", "0:100:0.5")
    assert "one line in 6 of 201" in " ".join(ran.out.split())
    assert len(ran.out.splitlines()) < 50


def test_modes(cli):
    ran = cli("modes", "fanuc_s360", "--posture", "configuration_1", "--width", 120)
    assert (ran.status, ran.err) == (0, "")
    assert "frequency [Hz]" in ran.out
    assert "pole [rad/s]" in ran.out
    assert " 7.6" in ran.out  # the first natural frequency, 7.6 Hz


def test_modes_overdamped(cli, urdf):
    ran = cli("modes", urdf(), "--posture", "q1=0.5", "--stiffness", "q1=100", "--damping", "1e4")
    assert ran.out.count("overdamped") == 2


@pytest.mark.parametrize(
    ("direction", "units"),
    [("tool:+z", ("N/m", "m²/rad²", "m/N")), ("tool:+ry", ("N·m/rad", "rad²/rad²", "rad/(N·m)"))],
)
def test_measures_have_the_units_of_their_direction(cli, direction, units):
    ran = cli(
        "measures", "fanuc_s360", "--posture", "configuration_1", "--direction", direction, "--frequency", "5"
    )
    assert (ran.status, ran.err) == (0, "")
    found = [line.split()[-1] for line in ran.out.splitlines() if "receptance" in line or "measure " in line]
    assert found[1:] == [*units, units[-1]]  # the first is the heading
    assert direction in ran.out


def test_optimise(cli):
    ran = cli(
        "optimise", "six_link", "--hold=-2,2", "--frequency", "5", "--starts", "1", "--start", "start_2",
        "--quiet",
    )  # fmt: skip
    assert (ran.status, ran.err) == (0, "")
    assert "a factor of" in ran.out
    assert "tool at (-2.0000, 0.0000, 2.0000) m" in ran.out


def test_optimise_where_nothing_can_be_gained(cli):
    ran = cli(
        "optimise", "fanuc_s360", "--free", "--frequency", "5", "--direction", "tool:+y", "--starts", "2",
        "--start", "configuration_1",
    )  # fmt: skip
    assert ran.status == 0  # out of its plane a planar chain does not move at all: 0 before and after
    assert "start 0 m/N, best 0\n" in ran.out


def test_check(cli, card, urdf):
    path = card()
    assert cli("check", path).out == f"{path}: sound\n"
    spoiled = urdf(
        ('<mass value="2"/>', '<mass value="-2"/>'), ('<axis xyz="0 -1 0"/>', '<axis xyz="0 0 0"/>')
    )
    ran = cli("check", path, spoiled)
    assert ran.status == 1
    assert ran.out.splitlines()[-1] == f"{spoiled}: 2 faults"


def test_check_of_what_is_not_there(cli, card):
    path = card()
    ran = cli("check", "no_such_robot", path)
    assert ran.status == 2
    assert ran.out == f"{path}: sound\n"  # the others are checked all the same
    assert "no_such_robot" in ran.err


def test_a_missing_mesh_is_a_warning(cli, urdf):
    visual = '<visual><geometry><mesh filename="package://nowhere/hand.stl"/></geometry></visual>'
    path = urdf(('<link name="hand">', f'<link name="hand">{visual}'))
    ran = cli("check", path)
    assert ran.status == 0
    assert "warning: mesh package://nowhere/hand.stl of link hand" in ran.out
    assert cli("modes", path, "--stiffness", "1e4", "--posture", "q1=0").status == 0


def test_help_of_every_command(cli):
    for command in ("robots", "check", "frf", "modes", "measures", "optimise", "show", "demo"):
        ran = cli(command, "--help")
        assert (ran.status, ran.err) == (0, "")
        assert f"Usage: flexmodal {command}" in ran.out
        assert command in cli("--help").out


def test_version(cli):
    from importlib.metadata import version

    assert cli("--version").out == f"flexmodal, version {version('flexmodal')}\n"


def test_show_writes_a_page_that_needs_no_network(cli, tmp_path):
    page = tmp_path / "page.html"
    ran = cli("show", "fanuc_s360", "--posture", "configuration_1", "--modes", "--out", page)
    assert (ran.status, ran.out) == (0, "")
    assert str(page) in ran.err
    text = page.read_text(encoding="utf-8")
    assert "fanuc" in text.lower()
    for address in ('src="http', "src='http", 'href="http', "src=http"):
        assert address not in text


def test_show_of_a_bare_urdf_with_its_deflection(cli, urdf, tmp_path):
    page = tmp_path / "page.html"
    ran = cli(
        "show", urdf(), "--stiffness", "1e4", "--damping", "1", "--frequency", "3", "--response", "tool:-z",
        "--out", page,
    )  # fmt: skip
    assert ran.status == 0
    assert page.stat().st_size > 100_000


def test_a_missing_posture_says_where_they_are_listed(cli):
    cli("modes", "six_link").refused("Missing option '--posture'", "flexmodal robots lists", "q1=50deg")
