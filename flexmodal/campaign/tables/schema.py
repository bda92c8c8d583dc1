"""What a column map may say, for pydantic; imported only while one is read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from flexmodal.campaign.description.schema import Id, TrialId
from flexmodal.frf import Form
from flexmodal.text.schema import Number, Table, Text
from flexmodal.text.validation import Contradiction

Place = Annotated[tuple[Id, Literal[-3, -2, -1, 1, 2, 3]], Field(strict=False)]


class FrfMap(Table):
    """`[[frf]]`."""

    posture: Id = Field(description="a whole number, 1 or more")
    trial: TrialId = Field(description="a whole number from 1 to 99999")
    response: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    reference: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    form: Form = Field(description="receptance, mobility or inertance")
    re: Text | None = Field(default=None, description="the header of a column, together with im")
    im: Text | None = Field(default=None, description="the header of a column, together with re")
    magnitude: Text | None = Field(default=None, description="the header of a column, together with phase")
    phase: Text | None = Field(
        default=None, description="the header of a column in degrees, together with magnitude"
    )
    coherence: Text | None = Field(default=None, description="the header of a column")
    scale: Number = Field(default=1.0, description="a finite factor from what the column holds to SI units")

    @model_validator(mode="after")
    def _one_way(self) -> FrfMap:
        cartesian, polar = (self.re, self.im), (self.magnitude, self.phase)
        for pair, other in ((cartesian, polar), (polar, cartesian)):
            if all(pair) and not any(other):
                return self
        raise Contradiction("", "no one way to the values", "re and im, or magnitude and phase")


class ChannelMap(Table):
    """One response of a blow."""

    response: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    column: Text = Field(description="the header of a column")
    scale: Number = Field(default=1.0, description="a finite factor from what the column holds to SI units")


class BlowMap(Table):
    """`[[blow]]`."""

    posture: Id = Field(description="a whole number, 1 or more")
    trial: TrialId = Field(description="a whole number from 1 to 99999")
    sequence: Id = Field(default=1, description="a whole number, 1 or more")
    reference: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    quantity: Literal["displacement", "velocity", "acceleration"] = Field(
        description="displacement, velocity or acceleration"
    )
    force: Text = Field(description="the header of a column")
    force_scale: Number = Field(default=1.0, description="a finite factor from what the column holds to N")
    channel: list[ChannelMap] = Field(
        min_length=1, description="tables with response, column and, if it has to be, scale"
    )


class ColumnMap(Table):
    """The whole file."""

    format: Literal[1] = Field(description="1")
    campaign: Text = Field(description="the path of a campaign.toml, relative to this file")
    table: Text = Field(description="the path of a .csv or .xlsx, relative to this file")
    sheet: Text | None = Field(default=None, description="the name of a sheet of the .xlsx")
    delimiter: Literal[",", ";", "\t"] = Field(default=",", description='",", ";" or a tabulator')
    decimal: Literal[".", ","] = Field(default=".", description='"." or ","')
    skip: int = Field(
        default=0,
        strict=True,
        ge=0,
        le=10_000,
        description="how many lines stand above the header, a whole number from 0 to 10000",
    )
    abscissa: Text = Field(description="the header of a column: Hz for FRFs, s for blows")
    frf: list[FrfMap] = Field(default=[], description="tables [[frf]]")
    blow: list[BlowMap] = Field(default=[], description="tables [[blow]]")
