"""What Python says to a page that it serves: receptance and modes at a posture, by Pinocchio."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot

MOST_LINES = 4000
"""Of a curve."""


class LiveAnswers:
    """A robot that answers a page's messages, each a JSON object with a number of its own."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    def __call__(self, text: str) -> str:
        """Answer a message: receptance and modes, or one sentence that says what is wrong with it.

        Args:
            text: `{"number", "q", "low", "high", "lines", "response", "reference"}`, q by joint [rad, m],
                frequencies [Hz].

        Returns:
            `{"number", "re", "im", "poles"}`, or `{"number", "error"}`.
        """
        number: int | None = None
        try:
            asked = json.loads(text, parse_int=float)
            if not isinstance(asked, dict):
                raise InvalidRequest(Fault("message", "", type(asked).__name__, "an object"))
            given = asked.get("number")
            number = int(given) if isinstance(given, float) and given.is_integer() else None
            said = self._curve(asked)
        except FlexmodalError as error:
            said = {"error": str(error)}
        except (ValueError, RecursionError):
            said = {"error": "message: no JSON"}
        return json.dumps({"number": number, **said})

    def _curve(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        low, high, lines = (self._number(asked, key) for key in ("low", "high", "lines"))
        if not (0 <= low < high and 2 <= lines <= MOST_LINES):
            found = f"{lines:g} lines from {low:g} to {high:g} Hz"
            raise InvalidRequest(
                Fault("message", "low, high, lines", found, f"up to {MOST_LINES}, ascending")
            )
        q = asked.get("q")
        if not isinstance(q, dict):
            raise InvalidRequest(Fault("message", "q", repr(q)[:80], "a value for each joint"))
        posed = self._robot.at(self._robot.posture(q, source="message"))
        ways = [
            PointDirection.parse(str(asked.get(key)), source="message") for key in ("response", "reference")
        ]
        axis = np.linspace(low, high, int(lines))
        value = posed.frf(axis, response=ways[0], reference=ways[1]).value[:, 0, 0]
        poles = posed.modes().pole
        return {
            "re": value.real.tolist(),
            "im": value.imag.tolist(),
            "poles": np.array([poles.real, poles.imag]).T.tolist(),
        }

    def _number(self, asked: Mapping[str, Any], key: str) -> float:
        value = asked.get(key)
        if not isinstance(value, float) or not np.isfinite(value):
            raise InvalidRequest(Fault("message", key, repr(value)[:80], "a finite number"))
        return value
