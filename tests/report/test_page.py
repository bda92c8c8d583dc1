"""Pages: every kind of part, names escaped, nothing fetched, and numbers in a table as they were given."""

import json
import re
from html.parser import HTMLParser

import pytest

from flexmodal.errors import OutputExists
from flexmodal.report import (
    Cell,
    Column,
    Facts,
    Folded,
    Gallery,
    Heading,
    Items,
    Legend,
    Numbers,
    Picture,
    Section,
    Table,
    Task,
    Text,
    Verdict,
    columns,
    drawing,
    new_figure,
    page_text,
    write_page,
)

HOSTILE = '</title></style><script>alert("1")</script>&<img src=x onerror=alert(2)> {{ 7 * 7 }} $\\frac{1$ _x'


class Page(HTMLParser):
    """Tags, attributes and words of a page, and whether its tags are closed in the order they are opened."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words, self._open = [], [], [], []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *pair) for pair in attrs]
        if tag not in ("meta", "br"):
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if not {"style", "svg"} & set(self._open):
            self.words.append(data.strip())


@drawing
def curve(label="a curve"):
    figure = new_figure(4.0, 3.0)
    axes = figure.subplots()
    axes.plot([1, 10, 100], [1e-6, 1e-4, 1e-5])
    axes.set(yscale="log", title=label, xlabel=label)
    return figure


def everything(name):
    """A page with every part in it, each with this name."""
    table = Table(
        [Column(name, words=True), Column(name, "m/N", group=name), Column("bar")],
        [[Cell(name, note=name, tag=name), "1.25", Cell("50 %", bar=0.5)],
         [name, "−3", Cell("", interval=(-0.5, 0.0, 2.0))]],
        chosen=frozenset({0}),
        faint=frozenset({1}),
    )  # fmt: skip
    picture = Picture(lambda: curve(name), name, name)
    parts = [
        name, Text(name, note=True, tag=name), Heading(name), table, picture, Gallery([picture, picture]),
        Items([name]), Items([], name), Facts({name: name}), Legend({"measured": name}),
        Task(name, Facts({name: name})), Folded(name, table), Folded(name, Numbers({name: name})),
    ]  # fmt: skip
    verdict = Verdict("open", name, [Text(name)], [(name, name, name)])
    return page_text(name, [verdict], [Section(name, parts)])


def test_every_part_is_on_the_page():
    page = Page(everything("plainly"))
    assert page.tags.count("svg") == 3
    assert page.tags.count("table") == 2
    assert {"h1", "h2", "h3", "ul", "dl", "details", "figcaption", "pre", "section"} <= set(page.tags)
    assert ("section", "class", "verdict open") in page.attributes
    styles = [value for tag, name, value in page.attributes if (tag, name) == ("i", "style")]
    assert "width:50.0%" in styles
    assert "left:25.0%;width:75.0%" in styles  # the interval ends at the end of the line
    assert page.words.count("plainly [m/N]") == 2


def test_names_are_only_text():
    text = everything(HOSTILE)
    page = Page(text)
    assert not {"script", "img"} & set(page.tags)
    assert "<script" not in text
    assert HOSTILE in page.words
    assert not [name for _, name, _ in page.attributes if name.startswith("on")]


def test_nothing_is_fetched():
    text = everything("plainly")
    page = Page(text)
    policy = next(value for _, name, value in page.attributes if name == "content" and "default-src" in value)
    assert policy.startswith("default-src 'none'")
    assert "script" not in policy
    assert not {"link", "iframe", "object", "embed", "base", "script"} & set(page.tags)
    outside = [value for _, name, value in page.attributes if name in ("src", "href", "xlink:href", "action")]
    assert all(value.startswith("#") for value in outside)
    assert "@import" not in text
    assert not re.search(r"url\((?!#)", text)


def test_numbers_as_json_are_the_numbers():
    value = {"depth": [0.1, 1e-300, None], "name": "<b>"}
    text = page_text("a page", [Numbers(value)])
    words = "".join(Page(text).words)
    assert json.loads(words[words.index("{") :]) == value
    with pytest.raises(ValueError, match="JSON"):
        page_text("a page", [Numbers({"depth": float("nan")})])


def test_headings_over_several_columns():
    kinds = [Column("model"), *(Column(kind, group=group) for group in ("fitted", "held") for kind in "ab")]
    assert Table(kinds, []).groups == [("", 1), ("fitted", 2), ("held", 2)]
    assert Table(columns(["a", "b"]), []).groups == []


def test_spaces_before_a_word_set_it_in():
    (line,) = Table(columns(["", ""]), [["  of it", "two  spaces"]]).lines
    assert [cell.text for cell in line] == ["\u2003of it", "two  spaces"]


def test_never_over_a_page(tmp_path):
    path = tmp_path / "page.html"
    write_page(path, "mine")
    with pytest.raises(OutputExists):
        write_page(path, "theirs")
    assert path.read_text(encoding="utf-8") == "mine"
    write_page(path, "theirs", overwrite=True)
    assert path.read_text(encoding="utf-8") == "theirs"
