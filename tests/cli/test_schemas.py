"""What `--json` prints is what its schema says, in runs that the schemas were not drawn from."""

import json
from pathlib import Path

import jsonschema
import pytest

from flexmodal.cli.main import SCHEMAS

ROOT = Path(__file__).parents[2]
CUT = ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml"
THESIS = ROOT / "robots" / "fanuc_s360" / "campaigns" / "thesis"
HAMMER = ROOT / "tests" / "data" / "real" / "free_free_beam" / "frf.uff"
LINE = ("--line=-2,2:-2,1.9", "--points", "2", "--feed", "0.1", "--nodes", "5")

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
]  # fmt: skip


@pytest.mark.parametrize("words", RUNS, ids=lambda words: " ".join(map(str, words))[:40])
def test_json_is_what_its_schema_says(cli, words):
    schema = json.loads((SCHEMAS / f"{words[0]}.json").read_text(encoding="utf-8"))
    jsonschema.validate(cli(*words, "--json").json(), schema)


def test_the_schema_of_a_card(cli, tmp_path):
    schema = json.loads((SCHEMAS / "card.json").read_text(encoding="utf-8"))
    jsonschema.validate(cli("card", "new", "xarm7", "--out", tmp_path, "--json").json(), schema)


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
