"""The line between a served page and Python: who may take it, and what is said on it."""

import json
import urllib.parse

import numpy as np
import pytest
from flexmodal_viewer.live_answers import LiveAnswers
from flexmodal_viewer.serve import PageServer
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from flexmodal.errors import InvalidRequest

ASKED = {"low": 0.0, "high": 50.0, "lines": 20, "response": "tool:+z", "reference": "location_3:-x"}


@pytest.fixture(scope="module")
def server(fanuc):
    with PageServer("<p>page</p>", answer=LiveAnswers(fanuc)) as found:
        found.start()
        yield found


def talk(server, *, path=None, origin=None, host=None):
    parts = urllib.parse.urlsplit(server.url)
    own = f"http://{parts.netloc}"
    return connect(
        f"ws://{parts.netloc}{parts.path if path is None else path}socket",
        origin=own if origin is None else origin or None,
        additional_headers={"Host": host} if host else None,
        open_timeout=10,
        proxy=None,
    )


def test_it_answers_with_pythons_numbers(server, fanuc):
    posture = fanuc.posture("configuration_1")
    with talk(server) as line:
        for number in (1, 2):
            line.send(json.dumps({"number": number, "q": dict(posture.values), **ASKED}))
            said = json.loads(line.recv(timeout=10))
            assert said["number"] == number
            axis = np.linspace(0, 50, 20)
            wanted = fanuc.at(posture).frf(axis, response="tool:+z", reference="location_3:-x").value[:, 0, 0]
            assert np.array_equal(np.array(said["re"]) + 1j * np.array(said["im"]), wanted)
            assert np.array_equal(np.array(said["poles"]) @ [1, 1j], fanuc.modes(posture).pole)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"q": {"nobody": 1.0}}, "nobody"),
        ({"q": {"q1": 99.0}}, "limits"),
        ({"q": {"q1": 10**400}}, "finite"),
        ({"q": [1, 2]}, "a value for each joint"),
        ({"lines": 10**9}, "4000"),
        ({"low": 60.0}, "ascending"),
        ({"high": "x"}, "a finite number"),
        ({"response": "nowhere:+z"}, "nowhere"),
        ({"response": None}, "None"),
    ],
)
def test_a_bad_question_gets_one_sentence_and_the_line_holds(server, fanuc, changed, words):
    good = {"number": 5, "q": dict(fanuc.posture("configuration_1").values), **ASKED}
    with talk(server) as line:
        line.send(json.dumps(good | changed))
        said = json.loads(line.recv(timeout=10))
        assert said["number"] == 5
        assert words in said["error"]
        line.send(json.dumps(good))
        assert "re" in json.loads(line.recv(timeout=10))


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '"q"', "NaN", '{"number": {}}', 100_000 * "["])
def test_what_is_no_question_is_said_so(fanuc, text):
    said = json.loads(LiveAnswers(fanuc)(text))
    assert said["number"] is None
    assert said["error"].startswith("message")


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"path": "/"}, 404),
        ({"path": "/AAAAAAAAAAAAAAAAAAAAAA/"}, 404),
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": ""}, 403),
    ],
)
def test_without_the_token_or_from_elsewhere_there_is_no_line(server, changed, status):
    with pytest.raises(InvalidStatus) as caught:
        talk(server, **changed)
    assert caught.value.response.status_code == status


def test_a_page_without_answers_has_no_line():
    with PageServer("<p>page</p>") as server:
        server.start()
        with pytest.raises(InvalidStatus) as caught:
            talk(server)
        assert caught.value.response.status_code == 404


def test_tokens_are_new_each_time():
    with PageServer("") as one, PageServer("") as other:
        first, second = (urllib.parse.urlsplit(server.url).path.strip("/") for server in (one, other))
    assert first != second
    assert len(first) >= 20


@pytest.mark.parametrize("host", ["0.0.0.0", "localhost", "", "example.org", "224.0.0.1", "127.0.0.1:80"])
def test_only_one_address_can_be_named(host):
    with pytest.raises(InvalidRequest, match="one address"):
        PageServer("", host=host)


def test_an_address_that_is_not_ours_is_refused():
    with pytest.raises(InvalidRequest, match=r"192\.0\.2\.1"):
        PageServer("", host="192.0.2.1")
