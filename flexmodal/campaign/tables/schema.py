"""What a column map may say, for pydantic; imported only while one is read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from flexmodal.campaign.description.schema import Id, Text, TrialId
from flexmodal.frf import Form

Place = Annotated[tuple[Id, Literal[-3, -2, -1, 1, 2, 3]], Field(strict=False)]
Factor = Annotated[float, Field(strict=True, allow_inf_nan=False)]

ALLOWED = {
    "format": "1",
    "campaign": "the path of a campaign.toml, relative to this file",
    "table": "the path of a .csv or .xlsx, relative to this file",
    "sheet": "the name of a sheet of the .xlsx",
    "delimiter": '",", ";" or a tabulator',
    "decimal": '"." or ","',
    "skip": "how many lines stand above the header, a whole number from 0 to 10000",
    "abscissa": "the header of a column: Hz for FRFs, s for blows",
    "frf": "tables [[frf]]",
    "blow": "tables [[blow]]",
    "posture": "a whole number, 1 or more",
    "trial": "a whole number from 1 to 99999",
    "sequence": "a whole number, 1 or more",
    "response": "[point id, direction ±1 ±2 ±3]",
    "reference": "[point id, direction ±1 ±2 ±3]",
    "form": "receptance, mobility or inertance",
    "quantity": "displacement, velocity or acceleration",
    "re": "the header of a column, together with im",
    "im": "the header of a column, together with re",
    "magnitude": "the header of a column, together with phase",
    "phase": "the header of a column in degrees, together with magnitude",
    "coherence": "the header of a column",
    "scale": "a finite factor from what the column holds to SI units",
    "force": "the header of a column",
    "force_scale": "a finite factor from what the column holds to N",
    "channel": "tables with response, column and, if it has to be, scale",
    "column": "the header of a column",
}
"""Key to what may stand there."""


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class FrfMap(_Table):
    """`[[frf]]`."""

    posture: Id
    trial: TrialId
    response: Place
    reference: Place
    form: Form
    re: Text | None = None
    im: Text | None = None
    magnitude: Text | None = None
    phase: Text | None = None
    coherence: Text | None = None
    scale: Factor = 1.0

    @model_validator(mode="after")
    def _one_way(self) -> FrfMap:
        cartesian, polar = (self.re, self.im), (self.magnitude, self.phase)
        for pair, other in ((cartesian, polar), (polar, cartesian)):
            if all(pair) and not any(other):
                return self
        raise ValueError("parts")


class ChannelMap(_Table):
    """One response of a blow."""

    response: Place
    column: Text
    scale: Factor = 1.0


class BlowMap(_Table):
    """`[[blow]]`."""

    posture: Id
    trial: TrialId
    sequence: Id = 1
    reference: Place
    quantity: Literal["displacement", "velocity", "acceleration"]
    force: Text
    force_scale: Factor = 1.0
    channel: Annotated[list[ChannelMap], Field(min_length=1)]


class ColumnMap(_Table):
    """The whole file."""

    format: Literal[1]
    campaign: Text
    table: Text
    sheet: Text | None = None
    delimiter: Literal[",", ";", "\t"] = ","
    decimal: Literal[".", ","] = "."
    skip: Annotated[int, Field(strict=True, ge=0, le=10_000)] = 0
    abscissa: Text
    frf: list[FrfMap] = []
    blow: list[BlowMap] = []
