"""The codes of dataset 58 that are used: kinds of function, quantities of the ordinate, their units."""

from __future__ import annotations

from flexmodal.campaign.blow import FORM_OF, Quantity
from flexmodal.frf import Form

TIME_RESPONSE, AUTO_SPECTRUM, FRF, COHERENCE = 1, 2, 4, 6
FUNCTIONS = {
    TIME_RESPONSE: "time response",
    AUTO_SPECTRUM: "auto spectrum",
    FRF: "FRF",
    COHERENCE: "coherence",
}
DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = 8, 11, 12, 13
QUANTITY_OF: dict[int, Quantity] = {
    DISPLACEMENT: "displacement",
    VELOCITY: "velocity",
    ACCELERATION: "acceleration",
}
WORDS: dict[int, str] = {**QUANTITY_OF, FORCE: "force"}
FORM_OF_CODE: dict[int, Form] = {code: FORM_OF[quantity] for code, quantity in QUANTITY_OF.items()}
CODE_OF: dict[str, int] = {
    **{quantity: code for code, quantity in QUANTITY_OF.items()},
    **{form: code for code, form in FORM_OF_CODE.items()},
}
"""Of a quantity or of a form: that of its response."""
EXPONENTS = {DISPLACEMENT: (1, 0), VELOCITY: (1, 0), ACCELERATION: (1, 0), FORCE: (0, 1), 0: (0, 0)}
"""Exponents of length and force, for readers that convert units; SI needs no conversion."""
