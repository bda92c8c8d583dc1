"""What a `robot.toml` may say, for pydantic.

Imported only while a card is read, since pydantic is slow to load. The models say what is valid;
`card_faults` says in words what is not.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1e18)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1e18)]
LossFactor = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=10)]
Signed = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1e18, le=1e18)]
Above1 = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=1)]
Below1 = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Name = Annotated[str, Field(strict=True, pattern=r"\A[A-Za-z0-9_.-]+\z")]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class JointTable(_Table):
    """`[joint.<name>]`."""

    stiffness: Positive
    damping: NotNegative
    pseudo: bool = False
    rotor_inertia: NotNegative = 0.0
    loss_factor: LossFactor = 0.0
    lower: Below1 | None = None
    upper: Above1 | None = None
    scale: Positive | None = None


class CouplingTable(_Table):
    """`[coupling."jointA+jointB"]`."""

    stiffness: Signed


class PointTable(_Table):
    """`[point.<name>]`."""

    link: Text
    xyz: Annotated[list[Number], Field(min_length=3, max_length=3)]


class FamilyTable(_Table):
    """`[family.<name>]`."""

    parameter: Text
    start: Number = Field(alias="from")
    stop: Number = Field(alias="to")
    follow: dict[Text, Number] = {}

    @model_validator(mode="after")
    def _runs_forward(self) -> FamilyTable:
        if self.start >= self.stop:
            raise ValueError("from")
        if self.parameter in self.follow:
            raise ValueError("follow")
        return self


class CardTable(_Table):
    """The whole file."""

    format: Literal[1]
    name: Name
    title: Text
    urdf: Text
    tool: Text
    source: Text
    loss_frequency: Positive | None = None
    joint: Annotated[dict[Text, JointTable], Field(min_length=1)]
    coupling: dict[Text, CouplingTable] = {}
    point: dict[Name, PointTable] = {}
    posture: dict[Name, dict[Text, Number]] = {}
    family: dict[Name, FamilyTable] = {}
