"""Figures: names as they are written, powers of ten in letters, colours of the page."""

import re
import xml.etree.ElementTree as ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from flexmodal.errors import OutputExists
from flexmodal.report.figure import (
    PALETTE,
    drawing,
    frequency_axis,
    headline,
    log_axis,
    look,
    new_figure,
    phase_axis,
    positive,
    short,
    svg_text,
    wrapped,
    write_figure,
)

FREQUENCY = np.geomspace(1.0, 200.0, 50)


@drawing
def spectrum(names=("receptance",), scale=1.0):
    figure = new_figure(6.0, 4.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for place, name in enumerate(names):
        upper.semilogy(FREQUENCY, scale * 10.0 ** (-4 - place) / FREQUENCY, label=name, **look(place))
        lower.plot(*wrapped(FREQUENCY, np.linspace(-900, 900, 50) % 360 - 180), **look(place))
    upper.legend()
    upper.set_title(names[0])
    phase_axis(lower)
    frequency_axis(lower, FREQUENCY)
    headline(figure, names[0])
    return figure


def texts(svg):
    return re.findall(r">([^<>]+)</text>", svg)


def test_powers_of_ten_are_letters():
    found = texts(svg_text(spectrum()))
    assert {"10⁻⁴", "10⁻⁵", "10⁻⁶"} <= set(found)
    assert not [text for text in found if "$" in text or "math" in text]


def test_less_than_a_decade_has_its_numbers():
    @drawing
    def narrow():
        figure = new_figure(4.0, 3.0)
        figure.subplots().semilogy([1, 2], [2.2e-5, 4.6e-5])
        return figure

    found = [text for text in texts(svg_text(narrow())) if "×" in text]
    assert "3×10⁻⁵" in found
    assert not [text for text in found if "\\" in text or "{" in text]


def test_frequencies_are_plain_numbers():
    found = texts(svg_text(spectrum()))
    assert {"1", "2", "5", "10", "20", "50", "100", "200"} <= set(found)
    assert "Frequency [Hz]" in found


def test_names_are_shown_as_they_are_written():
    name = "a$\\frac$b & <c>"
    svg = svg_text(spectrum([name]))
    ElementTree.fromstring(svg)
    assert texts(svg).count("a$\\frac$b &amp; &lt;c&gt;") == 3  # title, legend, headline


def test_on_a_page_colours_are_those_of_its_style_sheet():
    svg = svg_text(spectrum(list("abcdefg")))
    for number in range(1, len(PALETTE)):
        assert f"stroke: var(--c{number})" in svg
    assert "fill: var(--ink)" in svg
    left = set(re.findall(r": (#[0-9a-f]{6})\b", svg))
    assert left <= {"#000000"}  # what is not drawn at all
    assert svg.startswith('<svg style="--inch: 6"')


def test_the_same_figure_is_the_same_text():
    assert svg_text(spectrum()) == svg_text(spectrum())


def test_matplotlib_is_left_as_it_was():
    before = dict(mpl.rcParams)
    svg_text(spectrum())
    assert dict(mpl.rcParams) == before


def test_curves_differ_without_colours():
    styles = [look(place) for place in range(28)]
    assert len({(one["color"], one["linestyle"]) for one in styles}) == 28
    assert len({one["linestyle"] for one in styles[:4]}) == 4


@pytest.mark.parametrize("ending", [".png", ".svg"])
def test_files(tmp_path, ending):
    path = tmp_path / f"figure{ending}"
    write_figure(spectrum(), path)
    if ending == ".png":
        with Image.open(path) as image:
            assert image.size == (900, 600)
            assert np.asarray(image.convert("L"))[0, 0] == 255  # white paper
    else:
        text = path.read_text(encoding="utf-8")
        assert "var(" not in text  # colours that every reader knows
        assert PALETTE[0].lower() in text
    with pytest.raises(OutputExists):
        write_figure(spectrum(), path)


def test_phases_are_cut_where_they_wrap():
    frequency, phase = wrapped(np.array([1.0, 2.0, 3.0]), np.array([-170.0, 175.0, 170.0]))
    np.testing.assert_array_equal(frequency, [1.0, 2.0, 2.0, 3.0])
    np.testing.assert_array_equal(phase, [-170.0, np.nan, 175.0, 170.0])
    np.testing.assert_array_equal(positive(np.array([0.0, -2.0])), [np.nan, 2.0])


def test_short_names_stay_apart():
    names = [f"a_long_name_of_posture_{number}" for number in range(12)]
    cut = [short(name) for name in names]
    assert len(set(cut)) == 12
    assert max(map(len, cut)) == 18
    assert short("configuration_10") == "configuration_10"


def test_a_logarithmic_axis_up():
    @drawing
    def upright():
        figure = new_figure(4.0, 3.0)
        axes = figure.subplots()
        axes.plot([0, 1], [0.011, 0.4])
        log_axis(axes.yaxis)
        return figure

    assert {"0.02", "0.05", "0.1", "0.2"} <= set(texts(svg_text(upright())))
