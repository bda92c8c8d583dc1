"""The reports of diagnoses, from FRFs and from modes, in a browser: offline, at desk and telephone width, in
print."""

import html
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]

WIDTHS = (1200, 390)


VERDICT = {"frfs": "Missing: link flexibility (link_2)", "modes": "Added as asked, not decided"}
FRAME = {"frfs": (0, 114, 178), "modes": (177, 68, 0)}
"""Colour of the frame of the verdict: something found, something left open."""


@pytest.fixture(scope="module")
def from_modes():
    """The thesis's modes with two explanations that they do not tell apart, by one set of beliefs."""
    import flexmodal
    from flexmodal.campaign import read_campaign
    from flexmodal.diagnosis import diagnose
    from flexmodal.diagnosis.selection import variants

    effects = ["local_absorber@link_1", "local_absorber@link_2"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(variants, "VARIANTS", variants.VARIANTS[:1])
        campaign = read_campaign(ROOT / "robots/fanuc_s360/campaigns/thesis")
        return diagnose(campaign, flexmodal.load("fanuc_s360_rigid_link"), effects=effects)


@pytest.fixture(scope="module", params=["frfs", pytest.param("modes", marks=pytest.mark.slow)])
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def report(tmp_path_factory, request, kind):
    from flexmodal.diagnosis.report import write_report

    path = tmp_path_factory.mktemp("report") / f"report_{kind}.html"
    diagnosis = request.getfixturevalue("diagnosed" if kind == "frfs" else "from_modes")
    write_report(diagnosis, path, notes=("a note",))
    return path


def test_says_nothing_to_the_console(browser, report, kind):
    document, said = browser.document(report)
    assert VERDICT[kind] in document
    lines = [line for line in said.splitlines() if "CONSOLE" in line]
    assert lines == []


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_is_wider_than_the_window(browser, report, width, tmp_path):
    """The report lets no script run, so that a copy without that policy is what is measured.

    In a frame, since a window of Chromium's is never narrower than 500 pixels.
    """
    text = report.read_text(encoding="utf-8")
    copy = tmp_path / f"copy_{width}.html"
    script = (
        "<script>addEventListener('load', () => { const page = document.documentElement;"
        "page.dataset.wide = page.scrollWidth; page.dataset.window = innerWidth;"
        "const far = [...document.querySelectorAll('body *')].filter(one =>"
        " !one.closest('.wide') && !one.closest('svg') &&"
        " one.getBoundingClientRect().right > innerWidth + 1);"
        "page.dataset.far = far.map(one => one.tagName + '.' + one.className).join(' ') })</script>"
    )
    text = re.sub(r"<meta http-equiv=.*?>", "", text, count=1)
    page = html.escape(text.replace("</head>", f"{script}</head>"))
    copy.write_text(
        f"<iframe id=f style='width:{width}px;height:2000px;border:0' srcdoc=\"{page}\"></iframe>"
        "<script>f.onload = () => Object.assign("
        "document.documentElement.dataset, f.contentDocument.documentElement.dataset)</script>",
        encoding="utf-8",
    )
    document = browser.measured(copy, 1300)
    assert f'data-window="{width}"' in document
    assert f'data-wide="{width}"' in document
    assert 'data-far=""' in document


@pytest.mark.parametrize("width", WIDTHS)
def test_looks_as_it_should(browser, report, kind, width):
    picture = browser.picture(report, width=width, height=2400)
    dark = np.all(picture < 110, axis=2)
    assert 0.01 < dark.mean() < 0.4  # words and curves on a light ground
    edge = np.abs(picture - np.array(FRAME[kind])).max(axis=2) < 6
    assert edge.sum() > 1000  # the frame of the verdict
    assert np.all(picture[:, -4:] > 225)  # nothing runs over the edge
    orange = np.abs(picture - np.array([213, 94, 0])).max(axis=2) < 40
    assert orange.sum() > 200  # the place that is marked


@pytest.mark.slow
def test_prints(browser, report):
    pages, size = browser.printed(report)
    assert 3 <= pages <= 12
    assert size > 20_000
