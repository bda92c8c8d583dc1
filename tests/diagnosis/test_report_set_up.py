"""What the report says of how a test was set up."""

from unittest.mock import Mock

import pytest

from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.set_up import set_up_sections
from flexmodal.identification.sensitivities import Nuisance
from flexmodal.identification.setting_up import Found
from flexmodal.report import Table, Text

ANGLE = Nuisance("posture", 1, "q1", 0.01, "rad", "the angle of q1 in there")


def told(*moved):
    (section,) = set_up_sections(Mock(spec=Diagnosis, moved=moved))
    tables = [part for part in section.parts if isinstance(part, Table)]
    notes = [part.says for part in section.parts if isinstance(part, Text)]
    return [row for table in tables for row in table.rows], notes[-1]


def test_what_is_known_no_better_than_to_its_sign_is_counted_alone():
    sure, unsure = Found(ANGLE, -0.04, 0.002), Found(ANGLE, 0.001, 0.005)
    rows, note = told(sure, unsure, unsure)
    assert [row[0] for row in rows] == [ANGLE.says]
    assert rows[0][1] == "−0.04 rad"
    assert rows[0][-1] == "far outside"
    assert note == "2 more were moved by less than their standard error; they are in diagnosis.json."


@pytest.mark.parametrize(("count", "begins"), [(1, "One was moved"), (3, "All 3 were moved")])
def test_where_nothing_is_known_well_there_is_no_table(count, begins):
    rows, note = told(*[Found(ANGLE, 0.001, 0.005)] * count)
    assert rows == []
    assert note.startswith(begins)


def test_where_nothing_was_moved_there_is_no_section():
    assert set_up_sections(Mock(spec=Diagnosis, moved=())) == []
