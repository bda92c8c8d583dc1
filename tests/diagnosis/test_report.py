"""The report: what it says, that names are escaped and nothing is fetched, whatever the verdict."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from flexmodal.diagnosis.names import UNKNOWN
from flexmodal.diagnosis.outcome import Compared, Verdict
from flexmodal.diagnosis.report import write_report
from flexmodal.diagnosis.report.page import report_text
from flexmodal.diagnosis.report.pictures import over_noise, telling_rows
from flexmodal.diagnosis.report.tables import beside_card
from flexmodal.diagnosis.report.words import placed
from flexmodal.errors import OutputExists
from flexmodal.identification.frf_fit import residual
from flexmodal.report import figure as drawing
from flexmodal.report.words import figure

HOSTILE = '<script>alert("1")</script>&<img src=x onerror=alert(2)> $\\frac{1$ _x'


class Page(HTMLParser):
    """Words, tags and attributes of a page, headings apart."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.values, self.words, self.heads = [], [], [], []
        self._inside = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.values += [(tag, name, value) for name, value in attrs]
        self._inside = tag

    def handle_data(self, data):
        if self._inside not in ("style", "script"):
            self.words.append(data)
        if self._inside in ("h1", "h2", "h3"):
            self.heads.append(data)

    def handle_endtag(self, tag):
        self._inside = None

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.words))


@pytest.fixture(scope="module")
def page(diagnosed):
    return Page(report_text(diagnosed, ("the joint turns",)))


def test_what_the_model_leaves_is_what_the_verdict_goes_by(diagnosed):
    """Where a test was not set up exactly that is not one sum over all lines."""
    page = Page(report_text(replace(diagnosed, over_noise=7.4), ()))
    assert "the model leaves 7.4 × the noise" in page.text


def test_verdict_comes_first(page, diagnosed):
    text = page.text
    assert text.index("Missing: link flexibility (link_2)") < text.index("Where they disagree")
    assert diagnosed.verdict.says in text
    assert "These data cannot tell link flexibility (link_2) from local absorber (link_2)" in text
    assert "Confidence 93 %" in text


def test_every_part_is_there(page):
    heads = [head for head in page.heads if head.strip()]
    assert [head for head in heads if head in {
        "Where they disagree", "Measured and modelled", "What was compared", "How the gap came down",
        "Parameters", "What to measure next", "What this does not say", "Where it comes from",
    }] == [
        "Where they disagree", "Measured and modelled", "What was compared", "How the gap came down",
        "Parameters", "What to measure next", "What this does not say", "Where it comes from",
    ]  # fmt: skip
    assert page.tags.count("svg") == 3 + 6 + 1  # two maps and the arm, six FRFs, the descent


def test_numbers_are_the_diagnosis(page, diagnosed):
    text, gaps = page.text, diagnosed.gaps
    for value in (gaps.believed, gaps.before, gaps.after, gaps.noise_floor):
        assert f"{value:.3g}" in text
    (step,) = diagnosed.steps
    assert figure(step.parameters["stiffness"], "N·m/rad") in text
    assert "mode without structure" in text
    assert "nothing added" in text
    assert "coulomb friction could not be tested: one level of force only" in text
    assert "In the improved robot: the joint turns." in text
    assert "posture q1 = 68.8°, q2 = 17.2°, q3 = 0.0°" in text


def test_nothing_is_fetched_or_run(page):
    assert not {"script", "link", "img", "iframe", "object", "embed", "base"} & set(page.tags)
    outside = [
        (tag, name, value)
        for tag, name, value in page.values
        if name in ("href", "src", "xlink:href", "data", "action")
        and not str(value).startswith(("#", "data:image/png;base64,"))  # the colour bars of the maps
    ]
    assert outside == []
    assert not [value for _, name, value in page.values if name.startswith("on")]
    policy = next(value for tag, name, value in page.values if tag == "meta" and value and "default" in value)
    assert policy.startswith("default-src 'none'")


def test_hostile_names_are_only_text(diagnosed):
    observations = diagnosed.observations
    campaign = replace(
        observations.campaign,
        title=HOSTILE,
        points=tuple(replace(p, name=f"{HOSTILE}{p.id}") for p in observations.campaign.points),
        postures=tuple(replace(p, name=f"{HOSTILE}{p.id}") for p in observations.campaign.postures),
    )
    changed = replace(
        observations, campaign=campaign,
        postures=tuple(replace(p, name=f"{HOSTILE}{p.id}") for p in observations.postures),
    )  # fmt: skip
    context = replace(diagnosed.model.context, points=campaign.points, postures=changed.postures)
    region = replace(diagnosed.disagreement[0], kind=HOSTILE, says=HOSTILE)
    hostile = replace(
        diagnosed, campaign=HOSTILE, robot=HOSTILE, frfs=changed, disagreement=(region,),
        model=replace(diagnosed.model, context=context),
        remaining=(region,), verdict=replace(diagnosed.verdict, says=HOSTILE), left_out=(HOSTILE,),
        untestable={HOSTILE: HOSTILE}, provenance={HOSTILE: HOSTILE},
    )  # fmt: skip
    text = report_text(hostile, (HOSTILE,))
    found = Page(text)
    assert not {"script", "img"} & set(found.tags)
    assert "<script" not in text
    assert HOSTILE.split("&", maxsplit=1)[0] in found.text


@pytest.mark.usefixtures("no_ink")
def test_nothing_missing(diagnosed, hinged):
    root, before, _, _ = hinged
    nothing = replace(
        diagnosed, steps=(), verdict=Verdict((), True, "Nothing is missing."), model=root, x=before.x,
        deviation=np.zeros(len(before.x)), disagreement=(), next_measurement=None,
        predicted=dict(diagnosed.predicted) | {"after": diagnosed.predicted["before"]},
        refused=(
            Compared("none", "", 0.06, None, 0.0, 0.9, 0),
            Compared("added_mass", "link_1", 0.06, None, -2.0, 0.1, 3),
        ),
    )  # fmt: skip
    page = Page(report_text(nothing))
    assert "Nothing is missing" in page.text
    assert "Re-tuned, the robot is nowhere further from the measurements than their noise." in page.text
    assert "what else was tried did not gain enough" in page.text
    assert "added mass" in page.text
    assert page.tags.count("svg") == 2 + 6 + 1  # one map only


@pytest.fixture
def no_ink(monkeypatch):
    """Pictures are put together, and not rendered, which takes seconds a page."""
    monkeypatch.setattr(drawing, "svg_text", lambda figure: "<svg></svg>")


@pytest.mark.usefixtures("no_ink")
def test_not_explained(diagnosed):
    verdict = Verdict(((UNKNOWN, "link_3"),), False, "Something is missing that nothing explains.")
    page = Page(report_text(replace(diagnosed, steps=(), verdict=verdict, next_measurement=None)))
    assert "Something is missing that the catalogue does not know" in page.text
    assert "with the best that was tried" in page.text
    assert "link flexibility (link_2)" not in page.text  # never the nearest name


def test_map_is_the_disagreement_over_the_noise(diagnosed):
    """Bands with a factor of known size: rms |ln| over the rms noise, by hand."""
    observations = diagnosed.observations
    frequency = observations.axis.frequency
    edges = np.array([frequency[0], 30.0, frequency[-1]])
    found = over_noise(observations, observations.value * np.exp(0.3), edges)
    for number in range(len(observations.postures)):
        for band in range(2):
            lines = (frequency >= 30.0) == bool(band)
            used = observations.used[observations.posture == number][:, lines]
            noise = observations.variance[observations.posture == number][:, lines][used]
            np.testing.assert_allclose(found[number, band], 0.3 / np.sqrt(noise.mean()), rtol=1e-9)


def test_most_telling_pairs_come_first(diagnosed):
    rows = telling_rows(diagnosed)
    assert len(rows) == len(set(rows)) == 6
    size = np.mean(np.abs(residual(diagnosed.predicted["before"], diagnosed.observations.value)) ** 2, axis=1)
    assert size[rows[0]] > np.median(size)
    assert len({int(diagnosed.observations.posture[row]) for row in rows}) == 2


def test_parameters_beside_the_card(diagnosed):
    lines = beside_card(diagnosed).lines
    assert [line[0].text for line in lines[:2]] == ["stiffness of q1", "stiffness of q2"]
    values = diagnosed.model.space.values(diagnosed.x)
    line = next(line for line in lines if line[0].text == "mass of link_2")
    assert line[1].text == "2 kg"
    assert line[2].text == figure(values["mass.link_2"], "kg")
    change = 100 * (values["mass.link_2"] / 2.0 - 1)
    assert line[4].text == f"{change:+.1f} %".replace("-", "−")
    left, width, place = map(float, line[5].marks)
    assert 0 <= left <= place <= left + width + 0.1  # a decimal each


def test_effects_in_words():
    assert placed("joint_coupling", "q1+q2") == "joint coupling (q1+q2)"
    assert placed("none", "") == "nothing added"


@pytest.mark.slow
def test_never_over_a_page(diagnosed, tmp_path):
    path = tmp_path / "report.html"
    path.write_text("mine")
    with pytest.raises(OutputExists):
        write_report(diagnosed, path)
    assert path.read_text() == "mine"
    write_report(diagnosed, path, overwrite=True)
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
