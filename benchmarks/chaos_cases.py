"""Every command that writes, called so that it is done soon: what `chaos` kills."""

from __future__ import annotations

import contextlib
import io
import json
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import flexmodal
from flexmodal.cli.main import main as flexmodal_command

ROOT = Path(__file__).parents[1]
CUT = str(ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml")
SMALL = ("--postures", "2", "--points", "2", "--trials", "1", "--averages", "2", "--record-length", "1")
RIG = ("rig", "fanuc_s360", *SMALL, "--references", "1", "--quiet")
AXIS = ("--posture", "configuration_1", "--frequencies", "1:60:1")
KILL = (signal.SIGKILL,)
MAP = """\
format = 1
campaign = "{campaign}"
table = "table.csv"
abscissa = "f"
[[frf]]
posture = 1
trial = 1
response = [1, 3]
reference = [2, -3]
form = "inertance"
re = "re"
im = "im"
"""


@dataclass(frozen=True)
class Case:
    """A command, how it is called, and what it replaces."""

    name: str
    words: tuple[str, ...]
    out: str
    """Name of what it writes."""
    option: str = "--out"
    before: tuple[str, ...] = ()
    """The command that made what stands there; none where there is nothing to replace."""
    writers: int = 1
    """After each of so many kills the next writer is tried."""
    signals: tuple[signal.Signals, ...] = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
    step: int = 1
    """It is killed at the first of each so many events."""


@dataclass(frozen=True)
class Inputs:
    """What the commands read."""

    campaign: str
    single: str
    """Of one FRF."""
    three: str
    """Of three postures."""
    measurement: str
    """What a diagnosis asks for."""
    atlas: str
    urdf: str
    table: str
    map: str
    """What each of the table's columns is."""


def run(words: tuple[str, ...]) -> tuple[int, str]:
    """A command in this process: its status and what it complained of."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as told:
        try:
            flexmodal_command([str(word) for word in words])
        except SystemExit as left:
            return int(left.code or 0), told.getvalue()
    return 0, told.getvalue()


def call(case: Case, folder: Path) -> tuple[str, ...]:
    """The command with its output in a folder."""
    kind, equals, name = case.out.rpartition("=")
    force = ("--force",) if case.before else ()
    return (*case.words, case.option, f"{kind}{equals}{folder / name}", *force)


def make_inputs(home: Path) -> Inputs:
    """Small campaigns, an atlas, a bare URDF and a wish for a measurement."""
    campaign, single, three, atlas = (home / name for name in ("campaign", "single", "three", "input.zarr"))
    grid = ("--grid", "q1=0.5:1:3,q2=-1:0:5,q3=0", "--frequencies", "1:20:1", "--quiet", "--workers", "1")
    made = [
        (*RIG, "--out", str(campaign)),
        (*RIG, "--postures", "1", "--points", "1", "--out", str(single)),
        (*RIG, "--postures", "3", "--out", str(three)),
        ("atlas", "fanuc_s360", *grid, "--out", str(atlas)),
    ]
    for words in made:
        status, told = run(words)
        if status:
            raise RuntimeError(f"{' '.join(words)}: {told}")
    robot = flexmodal.load("fanuc_s360")
    angles = {name: float(robot.posture("configuration_6").values.get(name, 0.0)) for name in robot.commanded}
    measurement = home / "diagnosis.json"
    wish = {"next_measurement": {"posture": angles, "gain": 12.0}}
    measurement.write_text(json.dumps(wish), encoding="utf-8")
    urdf = str(ROOT / "urdf" / "six_axis.urdf")
    table, columns = home / "table.csv", home / "map.toml"
    table.write_text("f,re,im\n" + "".join(f"{n},{n},{-n}\n" for n in range(1, 40)), encoding="utf-8")
    columns.write_text(MAP.format(campaign=campaign / "campaign.toml"), encoding="utf-8")
    read = (campaign, single, three, measurement, atlas, urdf, table, columns)
    return Inputs(*map(str, read))


def cases(inputs: Inputs) -> tuple[Case, ...]:
    """All of them."""
    return (*_drawn(inputs), *_exported(), *_folders(inputs))


def _drawn(inputs: Inputs) -> tuple[Case, ...]:
    """Commands that write one file."""
    frf = ("frf", "fanuc_s360", *AXIS)
    fit = ("fit", inputs.campaign, "--no-vary", "--per", "posture")
    search = ("optimise", "fanuc_s360", "--family", "second_link_horizontal", "--frequency", "8", "--quiet")
    line = ("--line", "0.9,0.6:0.9,0.8", "--points", "3", "--feed", "0.1", "--frequency", "5", "--quiet")
    lobes = ("lobes", "fanuc_s360", "--cut", CUT, "--posture", "configuration_1", "--speeds", "5")
    look = ("lookup", inputs.atlas, "--frequency", "5")
    return (
        Case("frf", frf, "frf.csv"),
        Case("frf, arrays", frf, "frf.npz"),
        Case("frf --force", frf, "frf.uff", before=(*frf, "--form", "mobility")),
        Case("frf --force, a page", frf, "frf.html", before=(*frf, "--form", "mobility"), writers=5),
        Case("optimise, a picture", search, "receptance=best.png", "--plot"),
        Case("show", ("show", "fanuc_s360"), "page.html"),
        Case("path", ("path", "fanuc_s360", *line), "path.csv"),
        Case("lobes --force", lobes, "lobes.json", before=(*lobes, "--method", "multi-frequency"), writers=5),
        Case("lookup, a map", look, "map.html", "--map", writers=5),
        Case(
            "fit --force", fit, "modes.csv", before=("fit", inputs.campaign, "--no-vary", "--band", "5:100")
        ),
    )


def _exported() -> tuple[Case, ...]:
    at = ("export", "fanuc_s360", "--posture", "configuration_1", "--as")
    spatial = ("export", "six_axis", "--posture", "q1=0.1", "--as")
    return (
        Case("export mujoco", (*at, "mujoco"), "arm.xml"),
        Case("export state-space", (*at, "state-space"), "arm.npz"),
        Case("export joint-state", (*at, "joint-state"), "arm.yaml"),
        Case("export krl", (*spatial, "krl"), "arm.src"),
        Case("export rapid", (*spatial, "rapid"), "arm.mod"),
    )


def _folders(inputs: Inputs) -> tuple[Case, ...]:
    """Commands that write a folder, or several of either."""
    identify = ("identify", inputs.campaign, "--quiet")
    lean = ("diagnose", inputs.campaign, "--quiet", "--effects", "added_mass")
    go_on = ("rig", "--continue", inputs.campaign, "--as", inputs.measurement, "--quiet")
    stiff = (*identify, "--kinds", "stiffness")
    guess = ("card", "new", inputs.urdf)
    pictures = ("fit", inputs.single, "--no-vary")
    predict = ("predict", "fanuc_s360", "--campaign", inputs.three, "--posture", "q1=1.2,q2=-1,q3=0.1")
    predict = (*predict, "--method", "physics", "--quiet")
    return (
        Case("import --draft", ("import", inputs.table), "map.toml", "--draft"),
        Case("import", ("import", inputs.map), "test"),
        Case("campaign new", ("campaign", "new", "fanuc_s360"), "test"),
        Case("predict", predict, "frf.csv", writers=30, signals=KILL),
        Case("fit, pictures", pictures, "pictures", "--pictures", writers=10, signals=KILL),
        Case("card new", guess, "arm", writers=3),
        Case("rig", (*RIG, "--seed", "2", "--hide", "added_mass"), "test", signals=KILL),
        Case("rig --continue", go_on, "test", writers=3, signals=KILL),
        Case("identify", identify, "found", writers=10, signals=KILL),
        Case("identify --force", identify, "found", before=stiff, writers=10, signals=KILL),
        Case("diagnose", lean, "found", writers=30, signals=KILL),
        Case("diagnose --force", lean, "found", before=(*lean, "--seed", "1"), writers=30, signals=KILL),
        Case("demo", ("demo",), "demo", writers=100, signals=KILL, step=10),
    )


def together_cases(inputs: Inputs, folder: Path) -> dict[str, Callable[[int], tuple[str, ...]]]:
    """Commands that several call at once, each writing something else under the same name."""
    forms = ("receptance", "mobility", "inertance", "receptance")
    references = ("tool:+z", "tool:+z", "tool:+z", "tool:+x")
    kinds = ("stiffness", "damping", "mass", "inertia")
    frf = ("frf", "fanuc_s360", *AXIS, "--out", str(folder / "frf.csv"))
    found = ("identify", inputs.campaign, "--quiet", "--out", str(folder / "found"))
    return {
        "rig": lambda n: (*RIG, "--seed", str(n), "--out", str(folder / "t")),
        "frf": lambda n: (*frf, "--form", forms[n], "--reference", references[n]),
        "frf --force": lambda n: (*frf, "--form", forms[n], "--reference", references[n], "--force"),
        "identify --force": lambda n: (*found, "--kinds", kinds[n], "--force"),
    }
