"""What a `campaign.toml` may say, for pydantic: what is valid, and the sentence for where it is not.

Imported only while a campaign is read, since pydantic is slow to load.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from flexmodal.campaign.description.axes import AXES, FRAME, FRAME_OF_ROWS, axes_fault
from flexmodal.campaign.description.tested import BAND, USUAL
from flexmodal.campaign.trial import MOST_DIGITS, MOST_TRIAL
from flexmodal.text.schema import TEXT, Metres, NotNegative, Positive, Table, Text, Triple
from flexmodal.text.validation import Contradiction

_ID = f"a whole number from 1 to {MOST_DIGITS}"
_TRIAL_ID = f"a whole number from 1 to {MOST_TRIAL}"
_WINDOW = '"none", or { kind = "force" or "exponential", decay = a number in 1/s, 0 or more }'

TRACES = "lists of two or more ids of points, which pictures join one after the other"
SMALL = "a number from 0 to 1"
Small = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
Kilograms = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1e6)]
Frequency = Annotated[float, Field(strict=True, ge=0, le=1e9)]
Id = Annotated[int, Field(strict=True, ge=1, le=MOST_DIGITS)]
TrialId = Annotated[int, Field(strict=True, ge=1, le=MOST_TRIAL)]


class PostureTable(Table):
    """`[[posture]]`."""

    id: Id = Field(description=_ID)
    name: Text = Field(description=TEXT)
    q: dict[Text, Metres] = Field(description="a table of joint = finite angle in rad, of at most 1e4")
    locked: list[Text] = Field(default=[], description="a list of names of joints")
    masses: dict[Text, Kilograms] = Field(default={}, description="a table of point = mass in kg, above 0")


class PointTable(Table):
    """`[[point]]`."""

    id: Id = Field(description=_ID)
    name: Text = Field(description=TEXT)
    link: Text = Field(description="the name of a URDF link")
    xyz: Triple = Field(description="three finite numbers in m, of at most 1e4")
    axes: Literal["link"] | list[list[float]] | None = Field(default=None, description=AXES)
    frame: Literal["world", "link"] | None = Field(default=None, description=FRAME)

    @field_validator("axes", mode="before")
    @classmethod
    def _unit_vectors(cls, axes: object) -> object:
        """Rows are looked at as a whole, so that one sentence says what is wrong with which of them."""
        found = None if axes is None or axes == "link" else axes_fault(axes)
        if found is not None:
            raise Contradiction("", found, AXES)
        return axes if axes is None or axes == "link" else [[float(x) for x in row] for row in axes]  # type: ignore[attr-defined]

    @model_validator(mode="after")
    def _frame_of_rows(self) -> PointTable:
        """A frame belongs to rows, and rows to a frame."""
        if isinstance(self.axes, list) and self.frame is None:
            raise Contradiction("frame", "nothing", FRAME_OF_ROWS)
        if not isinstance(self.axes, list) and self.frame is not None:
            beside = "no axes" if self.axes is None else 'axes = "link"'
            raise Contradiction("frame", f'"{self.frame}" beside {beside}', FRAME)
        return self


class WindowTable(Table):
    """`window = { kind = …, decay = … }`."""

    kind: Literal["force", "exponential"]
    decay: NotNegative


class TrialTable(Table):
    """`[[trial]]`."""

    id: TrialId = Field(description=_TRIAL_ID)
    force_peak: Positive = Field(description="a number in N, above 0")
    averages: int = Field(strict=True, ge=1, le=1_000_000, description="a whole number, 1 or more")
    tip: Text = Field(description=TEXT)
    record_length: Positive | None = Field(default=None, description="a number in s, above 0")
    window: Literal["none"] | WindowTable = Field(default="none", description=_WINDOW)
    repeat_of: TrialId | None = Field(default=None, description="the id of another trial")

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


class ToleranceTable(Table):
    """`[tolerance]`: what is left out is as usual."""

    posture: Small = Field(default=USUAL.posture, description=f"{SMALL} in rad")
    position: Small = Field(default=USUAL.position, description=f"{SMALL} in m")
    direction: Small = Field(default=USUAL.direction, description=f"{SMALL} in rad")
    gain: Small = Field(default=USUAL.gain, description=SMALL)


class CampaignTable(Table):
    """The whole file."""

    format: Literal[1] = Field(description="1")
    title: Text = Field(description=TEXT)
    robot: Text = Field(description="a card's name, or a path relative to this file")
    band: Annotated[list[Frequency], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description=BAND
    )
    separate_modes: bool = Field(default=False, strict=True, description="true or false")
    tolerance: ToleranceTable | None = Field(default=None, description="a table [tolerance]")
    trace_lines: list[Annotated[list[Id], Field(min_length=2)]] = Field(default=[], description=TRACES)
    posture: list[PostureTable] = Field(min_length=1, description="at least one table [[posture]]")
    point: list[PointTable] = Field(min_length=1, description="at least one table [[point]]")
    trial: list[TrialTable] = Field(min_length=1, description="at least one table [[trial]]")
