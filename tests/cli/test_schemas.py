"""What `--json` prints is what its schema says, in runs that the schemas were not drawn from."""

import json
from pathlib import Path

import click
import jsonschema
import pytest

from flexmodal.cli.main import SCHEMAS, group

ROOT = Path(__file__).parents[2]
CUT = ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml"
THESIS = ROOT / "robots" / "fanuc_s360" / "campaigns" / "thesis"
HAMMER = ROOT / "tests" / "data" / "real" / "free_free_beam" / "frf.uff"
LINE = ("--line=-2,2:-2,1.9", "--points", "2", "--feed", "0.1", "--nodes", "3")

RUNS = [
    ("robots",),
    ("check", "six_link", "fanuc_s360"),
    ("frf", "six_link", "--posture", "start_1", "--frequencies", "5", "--form", "mobility"),
    ("frf", "six_link", "--posture", "start_1", "--frequencies", "5", "--response", "tip:+x", "--reference",
     "tip:+x", "--reference", "tip:+z"),
    ("modes", "fanuc_s360", "--posture", "configuration_2"),
    ("modes", "ur5", "--stiffness", "100", "--damping", "1e4", "--posture", "elbow_joint=1"),
    ("measures", "six_link", "--posture", "start_2", "--frequency", "8"),
    ("optimise", "fanuc_s360", "--free", "--frequency", "5", "--starts", "2"),
    ("optimise", "fanuc_s360", "--family", "second_link_horizontal", "--frequency", "12", "--start",
     "configuration_1"),
    ("optimise", "six_axis", "--hold", "0.8,0.1,0.9", "--objective", "stiffness", "--start", "work",
     "--starts", "2"),
    ("tune", "six_link", "--posture", "start_1", "--band", "3:60"),
    ("path", "six_link", "--frequency", "8", *LINE),
    ("lobes", "fanuc_s360", "--posture", "configuration_3", "--cut", CUT),
    ("lobes", "fanuc_s360", "--posture", "configuration_3", "--posture", "configuration_1", "--cut", CUT,
     "--speeds", "20"),
    ("fit", HAMMER, "--no-vary"),
    ("identify", THESIS, "--kinds", "stiffness,damping", "--hold-out", "configuration_1"),
    ("studies",),
    ("studies", "e11", "--starts", "4"),
    ("studies", "sweep_8", "frequency_1"),
]  # fmt: skip


HERE = Path(__file__).parent
ELSEWHERE = {
    "atlas": HERE / "test_atlas.py",
    "lookup": HERE / "test_atlas.py",
    "diagnose": HERE / "test_diagnose.py",
    "predict": HERE / "test_predict.py",
    "card": Path(__file__),
    "rig": Path(__file__),
}
"""Commands that need something made first, and the tests that hold what they print against their schema."""


def test_every_command_with_json_has_a_schema_and_a_run():
    context = click.Context(group)
    given = set()
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        parts = command.commands.values() if isinstance(command, click.Group) else [command]
        if any(option.name == "as_json" for part in parts for option in part.params):
            given.add(name)
    assert given == {path.stem for path in SCHEMAS.glob("*.json")}
    assert given == {words[0] for words in RUNS} | set(ELSEWHERE)
    for name, tests in ELSEWHERE.items():
        assert f'valid("{name}", ' in tests.read_text(encoding="utf-8")


@pytest.mark.parametrize("words", RUNS, ids=lambda words: " ".join(map(str, words))[:40])
def test_json_is_what_its_schema_says(cli, valid, words):
    valid(words[0], cli(*words, "--json").json())


def test_the_schema_of_a_card(cli, valid, tmp_path):
    valid("card", cli("card", "new", "xarm7", "--out", tmp_path, "--json").json())


def test_the_schema_of_a_rig(cli, valid, tmp_path):
    small = ("--postures", "1", "--points", "1", "--trials", "1", "--averages", "1", "--record-length", "1")
    made = cli("rig", "six_link", *small, "--peaks", "60", "--out", tmp_path / "test", "--json")
    assert valid("rig", made.json())["frfs"] == 1


@pytest.mark.parametrize("path", sorted(SCHEMAS.glob("*.json")), ids=lambda path: path.stem)
def test_schemas_are_sound_strict_and_printed(cli, path):
    schema = json.loads(path.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"nonsense": 1}, schema)
    command = [path.stem, "new"] if path.stem == "card" else [path.stem]
    ran = cli(*command, "--json-schema")
    assert ran.status == 0
    assert json.loads(ran.out) == schema
