"""Arguments that are wrong: the option or key, what was found, what is allowed; exit 2. The answer no: 1."""

import pytest

FRF = ("frf", "fanuc_s360", "--posture", "configuration_1")
SEARCH = ("optimise", "fanuc_s360", "--frequency", "5", "--starts", "2")
UR5 = ("modes", "ur5", "--posture", "elbow_joint=1")

POSTURES = {
    "configuration_9": ["'configuration_9'", "did you mean", "configuration_1, configuration_2"],
    "": ["''", "a named posture"],
    "q1=50deg,q7=1": ["unknown joint 'q7'", "q1, q2, q3"],
    "q11=1": ["unknown joint 'q11' (did you mean q1?)"],
    "rho=0.1": ["the pseudo-joint rho", "never commanded"],
    "q1=nan": ["q1", "found nan", "a finite number"],
    "q1=infdeg": ["q1", "found inf", "a finite number"],
    "q1=1e999": ["q1", "found inf", "a finite number"],
    "q1=-1": ["q1", "found -1", "0 to 3.14159, the joint's limits"],
    "q1=181deg": ["q1", "found 3.15905", "0 to 3.14159, the joint's limits"],
    "q1=fifty": ["q1", "'fifty'", "50deg"],
    "q1=50°": ["q1", "'50°'", "50deg"],
    "q1=deg": ["q1", "'deg'", "50deg"],
    "q1=1,": ["''", "name=value"],
    "q1=": ["'q1='", "name=value"],
    "=1": ["'=1'", "name=value"],
    "q1=1,q1=2": ["q1 twice", "each joint once"],
    "q1=1;q2=2": ["q1", "'1;q2=2'"],
}


@pytest.mark.parametrize("posture", POSTURES)
def test_postures(cli, posture):
    for command in (("modes", "fanuc_s360"), ("show", "fanuc_s360"), ("measures", "fanuc_s360")):
        cli(*command, "--posture", posture).refused("command line", "--posture", *POSTURES[posture])


def test_every_fault_of_a_posture_at_once(cli):
    lines = cli("modes", "fanuc_s360", "--posture", "q1=-1,q2=nan,q7=0,rho=0").refused()
    assert len(lines) == 4


FREQUENCIES = {
    "-5": ["negative", "-5 Hz"],
    "-5:5:1": ["-5:5:1", "≥ 0 Hz"],
    "": ["no frequencies", "at least one"],
    ",": ["no frequencies", "at least one"],
    "200:1:0.25": ["a reversed range, 200 to 1 Hz"],
    "5,1": ["5 Hz followed by 1 Hz", "ascending"],
    "5,5": ["5 Hz followed by 5 Hz", "ascending"],
    "1:200:0": ["a step of 0 Hz"],
    "1:200:-1": ["a step of -1 Hz"],
    "1:inf:1": ["1:inf:1", "finite"],
    "inf": ["inf Hz", "finite"],
    "nan": ["nan Hz", "finite"],
    "nan:2:1": ["nan:2:1", "finite"],
    "0:1e9:1e-3": ["a range of 1e+12 lines, more than 10,000,000"],
    "0:1e308:1e-308": ["more than 10,000,000"],
    "1e999": ["inf Hz", "finite"],
    "1e200": ["1e+200 Hz", "more than 1e+12 Hz"],
    "1:200": ["'1:200'", "START:STOP:STEP"],
    "1:2:3:4": ["'1:2:3:4'", "START:STOP:STEP"],
    "1::2": ["'1::2'", "START:STOP:STEP"],
    "all": ["'all'", "START:STOP:STEP"],
    "5Hz": ["'5Hz'", "START:STOP:STEP"],
}


@pytest.mark.parametrize("text", FREQUENCIES)
def test_frequencies(cli, text):
    cli(*FRF, "--frequencies", text).refused("command line --frequencies", *FREQUENCIES[text])


@pytest.mark.parametrize("text", ["-5", "nan", "inf", "1e999", "1e300", "five", ""])
def test_a_single_frequency(cli, text, tmp_path):
    for command in (
        ("measures", "fanuc_s360", "--posture", "configuration_1"),
        ("optimise", "fanuc_s360", "--free"),
        ("show", "fanuc_s360", "--out", tmp_path / "page.html"),
    ):
        lines = cli(*command, "--frequency", text).refused("command line", "frequenc", "; allowed: ")
        assert len(lines) == 1
    assert list(tmp_path.iterdir()) == []


DIRECTIONS = {
    "elbow:+z": ["'elbow'", "one of location_1", "tool"],
    "location_9:+z": ["'location_9' (did you mean", "location_1"],
    "tool:+q": ["'tool:+q'", "tool:+ry"],
    "tool:z+": ["'tool:z+'", "such as tool:+z"],
    "tool": ["'tool'", "such as tool:+z"],
    ":+z": ["':+z'", "such as tool:+z"],
    "": ["''", "such as tool:+z"],
    "tool:+zz": ["'tool:+zz'"],
}


@pytest.mark.parametrize("text", DIRECTIONS)
def test_points_and_directions(cli, text, tmp_path):
    for command in (
        (*FRF, "--frequencies", "1", "--response", text),
        (*FRF, "--frequencies", "1", "--response", "tool:+z", "--reference", text),
        ("measures", "fanuc_s360", "--posture", "configuration_1", "--direction", text),
        (*SEARCH, "--free", "--direction", text),
        ("show", "fanuc_s360", "--frequency", "3", "--response", text, "--out", tmp_path / "page.html"),
    ):
        cli(*command).refused("command line", *DIRECTIONS[text])


HOLDS = {
    "1": ["1 coordinates", "2 or 3 coordinates"],
    "1,2,3,4": ["4 coordinates", "2 or 3 coordinates"],
    "1,nan": ["--hold", "'nan'", "[m], finite"],
    "inf,1": ["--hold", "'inf'", "[m], finite"],
    "1e308,1e308": ["--hold", "'1e308'", "of a size"],
    "1,two": ["--hold", "'two'", "coordinates X,Z or X,Y,Z"],
    "1,": ["--hold", "''", "coordinates X,Z or X,Y,Z"],
    "": ["--hold", "''", "coordinates X,Z or X,Y,Z"],
    "1,0.5,1": ["0.5 m out of the plane"],
}


@pytest.mark.parametrize("text", HOLDS)
def test_holds(cli, text):
    cli(*SEARCH, "--hold", text).refused("command line", *HOLDS[text])


def test_a_spatial_chain_is_held_in_space(cli):
    ran = cli("optimise", "ur5", "--stiffness", "1e4", "--frequency", "5", "--hold", "0.5,0.5")
    ran.refused("2 coordinates", "3 coordinates (spatial chain)")


@pytest.mark.parametrize(("place", "options"), [("100,100", ()), ("1e5,-1e5", ("--json",))])
def test_out_of_reach_is_the_answer_no(shell, place, options):
    (line,) = shell(*SEARCH, "--hold", place, *options).refused(
        "no posture within the joint limits puts tool at", status=1
    )
    assert "of 2 starts" in line
    assert "m away" in line


def test_driven_at_an_undamped_resonance_is_the_answer_no(cli, urdf):
    path = urdf()
    arm = (path, "--stiffness", "q1=1000", "--posture", "q1=0.5")
    frequency = cli("modes", *arm, "--json").json()["modes"][0]["frequency"]
    command = ("frf", *arm, "--frequencies", repr(frequency))
    (line,) = cli(*command).refused("the receptance is infinite at", "give the joints damping", status=1)
    assert f"{frequency:.9g} Hz" in line
    (_, *rest) = arm
    assert cli("frf", path, *rest, "--damping", "0.1", "--frequencies", repr(frequency)).status == 0


REQUESTS = {
    "no way to hold": (("optimise", "fanuc_s360", "--frequency", "5"), ["exactly one of --hold"]),
    "two ways to hold": ((*SEARCH, "--free", "--hold", "1,1"), ["--hold and --free", "exactly one of"]),
    "unknown family": (
        (*SEARCH, "--family", "sideways"),
        ["--family", "'sideways'", "second_link_horizontal"],
    ),
    "no families": (
        ("optimise", "six_link", "--frequency", "5", "--family", "x"),
        ["--family", "the card has no families"],
    ),
    "no frequency": (("optimise", "fanuc_s360", "--free"), ["--frequency HZ or --band LOW:HIGH"]),
    "frequency and band": ((*SEARCH, "--free", "--band", "1:5"), ["given with --band"]),
    "band reversed": (
        ("optimise", "fanuc_s360", "--free", "--band", "5:1"),
        ["--band", "'5:1'", "LOW < HIGH"],
    ),
    "band NaN": (("optimise", "fanuc_s360", "--free", "--band", "nan:1"), ["--band", "'nan:1'"]),
    "band open": (("optimise", "fanuc_s360", "--free", "--band", "5:"), ["--band", "'5:'"]),
    "stiffness at a frequency": (
        (*SEARCH, "--free", "--objective", "stiffness"),
        ["--frequency", "has no frequency"],
    ),
    "two directions of one measure": (
        (*SEARCH, "--free", "--direction", "tool:+z", "--direction", "tool:+x"),
        ["2 directions", "one for --objective receptance"],
    ),
    "weights 0": (
        (*SEARCH, "--free", "--objective", "weighted", "--direction", "tool:+z=0"),
        ["weights", "not all 0"],
    ),
    "weight NaN": (
        (*SEARCH, "--free", "--objective", "weighted", "--direction", "tool:+z=nan"),
        ["--direction", "'nan'"],
    ),
    "null-space without a start": (
        (*SEARCH, "--free", "--method", "null-space"),
        ["the null-space method needs"],
    ),
    "null-space along a family": (
        (
            *SEARCH,
            "--family",
            "second_link_horizontal",
            "--method",
            "null-space",
            "--start",
            "configuration_1",
        ),
        ["null-space along a family"],
    ),
    "no starts": (
        ("optimise", "fanuc_s360", "--free", "--frequency", "5", "--starts", "0"),
        ["--starts", "1<=x<=100000"],
    ),
    "a bad start": ((*SEARCH, "--free", "--start", "q1=9"), ["--start", "q1", "limits"]),
    "seed -1": ((*SEARCH, "--free", "--seed", "-1"), ["--seed"]),
    "port 70000": (("show", "fanuc_s360", "--port", "70000"), ["--port", "65535"]),
    "port -1": (("show", "fanuc_s360", "--port", "-1"), ["--port"]),
    "two campaigns to compare": (
        ("show", "fanuc_s360", "--compare", "fanuc_s360/thesis", "--compare", "fanuc_s360/thesis"),
        ["--compare", "one campaign"],
    ),
    "four cards to compare": (
        ("show", "fanuc_s360", *4 * ("--compare", "six_link")),
        ["--compare", "at most 3"],
    ),
    "a campaign without FRFs to compare": (
        ("show", "fanuc_s360", "--compare", "fanuc_s360/thesis", "--out", "page.html"),
        ["no FRFs and no blows"],
    ),
    "page as a drawing": (("show", "fanuc_s360", "--out", "page.svg"), ["--out", "'page.svg'", ".html"]),
    "film of an arm at rest": (
        ("show", "fanuc_s360", "--out", "page.gif"),
        ["page.gif", "stands still", "--modes or --frequency"],
    ),
    "unknown form": (
        (*FRF, "--frequencies", "1", "--form", "velocity"),
        ["--form", "'velocity'", "inertance"],
    ),
    "unknown objective": ((*SEARCH, "--free", "--objective", "beauty"), ["--objective", "'beauty'"]),
    "unknown option": (("robots", "--jason"), ["--jason"]),
    "unknown command": (("optimize",), ["optimize"]),
    "no posture": (("modes", "fanuc_s360"), ["--posture"]),
    "no robot": (("modes",), ["ROBOT"]),
    "one too many": (("robots", "fanuc_s360"), ["fanuc_s360"]),
    "a bare URDF without stiffness": (UR5, ["stiffness", "--stiffness NUMBER or joint=number"]),
    "stiffness with a unit": ((*UR5, "--stiffness", "5e5 N"), ["--stiffness", "'5e5 N'", "a number"]),
    "stiffness negative": ((*UR5, "--stiffness", "elbow_joint=-1"), ["stiffness of elbow_joint", "above 0"]),
    "stiffness 0": ((*UR5, "--stiffness", "elbow_joint=0"), ["stiffness of elbow_joint", "above 0"]),
    "stiffness NaN": ((*UR5, "--stiffness", "nan"), ["--stiffness", "'nan'", "finite"]),
    "stiffness 1e999": ((*UR5, "--stiffness", "1e999"), ["--stiffness", "'1e999'", "finite"]),
    "stiffness 1e308": ((*UR5, "--stiffness", "1e308"), ["--stiffness", "'1e308'", "of a size"]),
    "stiffness 1e-310": ((*UR5, "--stiffness", "1e-310"), ["--stiffness", "'1e-310'", "of a size"]),
    "stiffness empty": ((*UR5, "--stiffness", ""), ["--stiffness", "''"]),
    "stiffness of no joint": ((*UR5, "--stiffness", "knee=1"), ["'knee', which is no joint", "elbow_joint"]),
    "stiffness twice": ((*UR5, "--stiffness", "elbow_joint=1,elbow_joint=2"), ["elbow_joint twice"]),
    "damping negative": (
        (*UR5, "--stiffness", "1", "--damping", "elbow_joint=-1"),
        ["damping of elbow_joint"],
    ),
    "damping of a rigid joint": (
        (*UR5, "--stiffness", "elbow_joint=1", "--damping", "wrist_1_joint=1"),
        ["'wrist_1_joint', which is no flexible joint"],
    ),
    "unknown tool": ((*UR5, "--stiffness", "1", "--tool", "hammer"), ["tool", "'hammer'", "ee_link"]),
    "unknown joint to fix": ((*UR5, "--stiffness", "1", "--fix", "knee"), ["knee", "no joint of that name"]),
}


@pytest.mark.parametrize("kind", REQUESTS)
def test_requests(cli, kind):
    arguments, words = REQUESTS[kind]
    cli(*arguments).refused(*words)


def test_fixing_every_joint_leaves_none(cli, urdf):
    ran = cli("modes", urdf(), "--stiffness", "1", "--fix", "q1,bend,q2", "--posture", "q1=0")
    ran.refused("none that moves", "at least one")


def test_json_is_no_excuse(cli):
    """With --json a refusal is the same: nothing on standard output, a sentence on standard error."""
    cli(*FRF, "--frequencies", "-1", "--json").refused("-1 Hz")
    cli("modes", "nobody", "--posture", "x", "--json").refused("no robot of the name")
