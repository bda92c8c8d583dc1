"""Trace lines of a campaign: written and read, cut where nothing was measured, refused where no point is."""

from dataclasses import replace

import pytest

from flexmodal.campaign import read_campaign, write_campaign
from flexmodal.campaign.uff.export import through
from flexmodal.errors import InvalidCampaign


def test_they_are_written_and_read(campaign, tmp_path):
    ids = [point.id for point in campaign.points]
    lines = (tuple(ids), (ids[-1], ids[0]))
    folder = write_campaign(replace(campaign, trace_lines=lines), tmp_path / "traced")
    assert read_campaign(folder).trace_lines == lines
    assert read_campaign(write_campaign(campaign, tmp_path / "plain")).trace_lines == ()


def test_a_line_is_cut_at_nodes_that_are_no_points():
    lines = ((1, 2, 3, 4, 5, 6), (7, 8), (3, 1))
    assert through(lines, {1, 2, 4, 5, 6, 7}) == ((1, 2), (4, 5, 6))
    assert through(lines, {1, 3}) == ((3, 1),)


def test_lines_through_strangers_are_refused(campaign, tmp_path):
    with pytest.raises(InvalidCampaign, match=r"trace_lines\[1\].*point 98, 99.*points of this campaign"):
        replace(campaign, trace_lines=((1, 2), (1, 99, 98)))
    file = write_campaign(campaign, tmp_path / "plain") / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(
        text.replace("format = 1", "format = 1\ntrace_lines = [[1, 77], [2], 5]"), encoding="utf-8"
    )
    with pytest.raises(InvalidCampaign) as caught:
        read_campaign(file.parent)
    keys = [fault.key for fault in caught.value.faults]
    assert any("trace_lines" in key for key in keys)
