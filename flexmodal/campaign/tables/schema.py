"""What a column map may say, for pydantic; imported only while one is read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from flexmodal.campaign.description.schema import Id, TrialId
from flexmodal.frf import Form
from flexmodal.text.schema import Number, Positive, Table, Text
from flexmodal.text.validation import Contradiction

Place = Annotated[tuple[Id, Literal[-3, -2, -1, 1, 2, 3]], Field(strict=False)]


class FrfMap(Table):
    """`[[frf]]`."""

    posture: Id = Field(description="a whole number, 1 or more")
    trial: TrialId = Field(description="a whole number from 1 to 99999")
    response: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    reference: Place = Field(description="[point id, direction ±1 ±2 ±3]")
    form: Form = Field(description="receptance, mobility or inertance")
    table: Text | None = Field(default=None, description="the path of another table than the map's")
    value: Text | None = Field(default=None, description="the name of a variable of complex numbers")
    re: Text | None = Field(default=None, description="the header of a column, together with im")
    im: Text | None = Field(default=None, description="the header of a column, together with re")
    magnitude: Text | None = Field(default=None, description="the header of a column, together with phase")
    phase: Text | None = Field(default=None, description="the header of a column, together with magnitude")
    decibel: bool = Field(default=False, strict=True, description="true where magnitude is 20 log₁₀ of it")
    phase_unit: Literal["degrees", "radians"] = Field(default="degrees", description="degrees or radians")
    coherence: Text | None = Field(default=None, description="the header of a column")
    scale: Number = Field(default=1.0, description="a finite factor from what the column holds to SI units")

    @model_validator(mode="after")
    def _one_way(self) -> FrfMap:
        ways = ((self.re, self.im), (self.magnitude, self.phase), (self.value,))
        given = [way for way in ways if any(way)]
        if len(given) == 1 and all(given[0]):
            return self
        if len(given) == 1 and self.magnitude is not None:
            found = "a magnitude without its phase"
            allowed = "both: modes, directions and the fit of a model are in the phase; export re and im"
            raise Contradiction("", found, allowed)
        raise Contradiction("", "no one way to the values", "re and im, or magnitude and phase, or value")


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
    table: Text | None = Field(default=None, description="the path of another table than the map's")
    length: Positive | None = Field(
        default=None, description="of each blow, a number in s above 0, where the record holds several"
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
    table: Text = Field(description="the path of a table, relative to this file")
    sheet: Text | None = Field(default=None, description="the name of a sheet of the .xlsx")
    delimiter: Literal[",", ";", "\t", " "] = Field(
        default=",", description='",", ";", a tabulator, or " " for any white space'
    )
    decimal: Literal[".", ","] = Field(default=".", description='"." or ","')
    skip: int = Field(
        default=0,
        strict=True,
        ge=0,
        le=10_000,
        description="how many lines stand above the header, a whole number from 0 to 10000",
    )
    units_rows: int = Field(
        default=0, strict=True, ge=0, le=10, description="how many rows under the header are no numbers"
    )
    transposed: bool = Field(
        default=False, strict=True, description="true where each row is a column, its header first"
    )
    abscissa: Text = Field(description="the header of a column: Hz for FRFs, s for blows")
    frf: list[FrfMap] = Field(default=[], description="tables [[frf]]")
    blow: list[BlowMap] = Field(default=[], description="tables [[blow]]")
