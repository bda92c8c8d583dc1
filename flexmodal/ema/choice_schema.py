"""What a file of chosen modes may say, for pydantic; imported only while one is read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from flexmodal.campaign.description.schema import Id
from flexmodal.text.schema import Number, Positive, Table
from flexmodal.text.validation import Contradiction

_MOST = 500


class ModeTable(Table):
    """`[[posture.mode]]`."""

    frequency: Positive = Field(description="a frequency above 0 Hz")
    damping_ratio: Annotated[float, Field(strict=True, gt=0, lt=1)] = Field(
        description="a damping ratio between 0 and 1"
    )


class PostureTable(Table):
    """`[[posture]]`."""

    id: Id = Field(description="a whole number, 1 or more")
    fingerprint: Annotated[list[Number], Field(min_length=7, max_length=7)] = Field(
        description="the seven numbers that the page of a fit wrote"
    )
    mode: Annotated[list[ModeTable], Field(min_length=1, max_length=_MOST)] = Field(
        description=f"1 to {_MOST} tables [[posture.mode]]"
    )


class ChoiceTable(Table):
    """The file."""

    format: Literal[1] = Field(description="1")
    title: str = Field(default="", strict=True, description="some text")
    residuals: Literal["none", "real", "complex"] = Field(
        default="complex", description="none, real or complex"
    )
    band: Annotated[list[Positive], Field(min_length=2, max_length=2)] = Field(
        description="[low, high] in Hz, low below high"
    )
    posture: Annotated[list[PostureTable], Field(min_length=1)] = Field(
        description="at least one table [[posture]]"
    )

    @model_validator(mode="after")
    def _band_ascends(self) -> ChoiceTable:
        if self.band[0] >= self.band[1]:
            found = f"{self.band[0]:g} to {self.band[1]:g} Hz"
            raise Contradiction("band", found, "[low, high] in Hz, low below high")
        return self
