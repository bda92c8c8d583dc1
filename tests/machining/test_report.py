"""Objects, files and pictures of lobes and comparisons."""

import csv
import html
import json
import re

import numpy as np
import pytest
from PIL import Image

from flexmodal.errors import OutputExists
from flexmodal.machining import ToolMode, compare_family, compare_postures, lobes, report, stability_lobes
from flexmodal.machining.plot import draw_comparison, draw_lobes
from flexmodal.report import svg_text, write_figure

MODES = (ToolMode("x", 780.0, 0.03, 9e6), ToolMode("y", 850.0, 0.03, 1e7))


@pytest.fixture(scope="module")
def fed(across):
    from dataclasses import replace

    cut = across(modes=MODES, speeds=(3000.0, 20000.0))
    return replace(cut, engagement=replace(cut.engagement, feed_per_tooth=1e-4, depth=2e-4))


@pytest.fixture(scope="module")
def one(fanuc, fed):
    return lobes(fanuc, "configuration_1", fed, speeds=60)


@pytest.fixture(scope="module")
def several(fanuc, fed):
    return compare_family(fanuc, "second_link_horizontal", fed, members=3)


def test_object_of_one(one):
    found = report.lobes_object("fanuc_s360", one)
    json.dumps(found, allow_nan=False)
    assert found["critical_depth"] == min(found["depth"])
    assert found["critical_speed"] == found["spindle_speed"][int(np.argmin(found["depth"]))]
    assert len(found["depth"]) == len(found["chatter_frequency"]) == len(found["lobe"])
    assert found["best"][0]["depth"] == max(found["depth"])
    assert found["mode_coupling"]["frequency"] == one.coupling.frequency
    forced = found["forced"]
    assert forced["depth"] == 2e-4
    assert np.shape(forced["peak"]) == (len(found["depth"]), 3)
    assert forced["stable"] == [depth > 2e-4 for depth in found["depth"]]


def test_no_limit_is_null_and_in_words(fanuc, across):
    """So fast that the teeth damp every mode of the arm."""
    cut = across(speeds=(90000.0, 100000.0))
    found = lobes(fanuc, "configuration_1", cut, speeds=10)
    text = report.lobes_object("f", found)
    json.dumps(text, allow_nan=False)
    assert text["depth"] == [None] * 10
    assert text["critical_depth"] is None
    assert report.millimetres(np.inf) == "no limit"
    assert report.hertz(np.nan) == "–"
    assert text["forced"] is None


def test_csv_of_one(one, tmp_path):
    path = tmp_path / "lobes.csv"
    report.write_lobes_csv(one, path)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == report.LOBES_COLUMNS
    np.testing.assert_array_equal([float(row["spindle_speed_rev_per_min"]) for row in rows], one.lobes.speed)
    np.testing.assert_array_equal([float(row["stable_depth_m"]) for row in rows], one.lobes.depth)
    np.testing.assert_array_equal([float(row["peak_y_m"]) for row in rows], one.forced.peak[:, 1])
    with pytest.raises(OutputExists):
        report.write_lobes_csv(one, path)


def test_csv_of_several(several, tmp_path):
    path = tmp_path / "postures.csv"
    report.write_comparison_csv(several, path)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == report.COMPARISON_COLUMNS
    depths = [float(row["critical_depth_m"]) for row in rows]
    assert depths == [found.critical_depth for found in several.postures]
    assert [float(row["parameter"]) for row in rows] == [found.parameter for found in several.postures]


def test_object_of_several(several):
    found = report.comparison_object(several)
    json.dumps(found, allow_nan=False)
    assert found["family"] == "second_link_horizontal"
    depths = [entry["critical_depth"] for entry in found["postures"]]
    assert found["best"] == int(np.argmax(depths))
    assert found["gain"] == pytest.approx(max(depths) / min(depths))


@pytest.mark.parametrize("kind", ["one", "several"])
def test_pages_need_no_network(one, several, tmp_path, kind):
    path = tmp_path / "page.html"
    if kind == "one":
        report.write_lobes_page("<b>robot</b>", one, path)
    else:
        report.write_comparison_page(several, path)
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"(?:src|href)\s*=\s*[\"']?\s*(?:https?:)?//", text)
    assert text.count("<svg") == 1
    assert "<b>robot" not in text
    assert (html.escape("<b>robot</b>") in text) == (kind == "one")


def texts(figure):
    return set(re.findall(r">([^<>]+)</text>", svg_text(figure)))


def test_the_picture_names_its_axes(one):
    found = texts(report.lobes_picture("fanuc_s360", one))
    assert {
        "Axial depth of cut [mm]", "Chatter frequency [Hz]", "Spindle speed [rev/min]", "Surface error [µm]",
        "stable", "stability limit",
    } <= found  # fmt: skip
    assert any("mode coupling" in text for text in found)
    assert any("configuration_1" in text for text in found)


@pytest.mark.slow
def test_pictures_of_every_kind(one, several, fanuc, fed, benchmark, tmp_path):
    cut, tip = benchmark(immersion=0.05, axes="xy")
    speeds = np.array([18000.0, 19000.0, 20000.0, 21000.0])
    flips = stability_lobes(tip, cut, method="multi-frequency", speeds=speeds)
    names = compare_postures(fanuc, ["configuration_1", "configuration_7"], fed)
    unlimited = stability_lobes(benchmark(axes="z")[1], cut, speeds=speeds)
    figures = {
        "flips": draw_lobes({"zero-order": stability_lobes(tip, cut, speeds=speeds), "whole": flips}),
        "none": draw_lobes({"": unlimited}, coupling=np.inf),
        "family": draw_comparison(several),
        "names": draw_comparison(names),
        "one": report.lobes_picture("fanuc_s360", one),
    }
    for name, figure in figures.items():
        path = tmp_path / f"{name}.png"
        write_figure(figure, path)
        with Image.open(path) as image:
            assert min(image.size) > 500
    assert "period doubling" in texts(figures["flips"])
    assert "no limit found" in texts(figures["none"])
    assert "q1 of family second_link_horizontal [rad]" in texts(figures["family"])
    assert "configuration_7" in texts(figures["names"])


def test_how_much_of_the_range_is_stable(one):
    assert report.stable_part(one).endswith("%")
    rows = {row[0].strip(): row[1] for row in report.numbers(one)}
    assert rows["critical depth over the range of speeds"] == report.millimetres(one.critical_depth)
