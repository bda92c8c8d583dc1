"""What a `campaign.toml` may say, for pydantic.

Imported only while a campaign is read, since pydantic is slow to load. The models say what is valid;
`toml_faults` says in words what is not.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from flexmodal.campaign.trial import MOST_DIGITS, MOST_TRIAL

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Id = Annotated[int, Field(strict=True, ge=1, le=MOST_DIGITS)]
TrialId = Annotated[int, Field(strict=True, ge=1, le=MOST_TRIAL)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class PostureTable(_Table):
    """`[[posture]]`."""

    id: Id
    name: Text
    q: dict[Text, Number]


class PointTable(_Table):
    """`[[point]]`."""

    id: Id
    name: Text
    link: Text
    xyz: Annotated[list[Number], Field(min_length=3, max_length=3)]


class WindowTable(_Table):
    """`window = { kind = …, decay = … }`."""

    kind: Literal["force", "exponential"]
    decay: NotNegative


class TrialTable(_Table):
    """`[[trial]]`."""

    id: TrialId
    force_peak: Positive
    averages: Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
    tip: Text
    record_length: Positive | None = None
    window: Literal["none"] | WindowTable = "none"
    repeat_of: TrialId | None = None

    @field_validator("window", mode="before")
    @classmethod
    def _spelt_out(cls, window: object) -> object:
        """`"exponential 2.5"` and `"force 40"` mean the same as the table."""
        if isinstance(window, str) and window != "none":
            kind, _, decay = window.partition(" ")
            try:
                return {"kind": kind, "decay": float(decay.strip().removesuffix("1/s"))}
            except ValueError:
                return window
        return window


class CampaignTable(_Table):
    """The whole file."""

    format: Literal[1]
    title: Text
    robot: Text
    band: Annotated[list[NotNegative], Field(min_length=2, max_length=2)] | None = None
    posture: Annotated[list[PostureTable], Field(min_length=1)]
    point: Annotated[list[PointTable], Field(min_length=1)]
    trial: Annotated[list[TrialTable], Field(min_length=1)]
