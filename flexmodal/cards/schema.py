"""What a `robot.toml` may say, for pydantic: what is valid, and the sentence for where it is not.

Imported only while a card is read, since pydantic is slow to load.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from flexmodal.text.schema import TEXT, Number, Table, Text, Triple
from flexmodal.text.validation import Contradiction
from flexmodal.text.words import shown

_CARD_NAME = "a name of letters, digits, _ . and -"
_ANGLE = "a finite number in rad (m for a prismatic joint)"

Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1e-12, le=1e18)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1e18)]
Hertz = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1e-6, le=1e9)]
LossFactor = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=10)]
Length = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1e-9, le=1e4)]
Signed = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1e18, le=1e18)]
_DEVIATION = "a relative standard deviation, above 0 and at most 3"
Deviation = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=3)]
Above1 = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=1)]
Below1 = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)]
Angle = Annotated[float, Field(strict=True, allow_inf_nan=False, description=_ANGLE)]
Factor = Annotated[float, Field(strict=True, allow_inf_nan=False, description="a finite factor")]
Name = Annotated[str, Field(strict=True, pattern=r"\A[A-Za-z0-9_.-]+\z", description=_CARD_NAME)]
Pair = Annotated[str, Field(strict=True, min_length=1, description=_CARD_NAME)]
JointName = Annotated[str, Field(strict=True, min_length=1, description="the name of a joint")]
Angles = Annotated[dict[JointName, Angle], Field(description="a table of joint = angle")]


class JointTable(Table):
    """`[joint.<name>]`."""

    stiffness: Positive = Field(
        description="a number in N·m/rad (N/m for a prismatic joint), above 0 (from 1e-12) and at most 1e18"
    )
    damping: NotNegative = Field(
        description="a number in N·m·s/rad (N·s/m for a prismatic joint), from 0 to 1e18"
    )
    pseudo: bool = Field(default=False, description="true or false")
    rotor_inertia: NotNegative = Field(
        default=0.0, description="a number in kg·m² (kg for a prismatic joint), from 0 to 1e18"
    )
    loss_factor: LossFactor = Field(default=0.0, description="a number from 0 to 10")
    lower: Below1 | None = Field(
        default=None, description="a factor on the values of the card, above 0 and below 1"
    )
    upper: Above1 | None = Field(default=None, description="a factor on the values of the card, above 1")
    scale: Positive | None = Field(default=None, description="a relative standard deviation, above 0")


class CouplingTable(Table):
    """`[coupling."jointA+jointB"]`."""

    stiffness: Signed = Field(description="a number in N·m/rad, of either sign, of at most 1e18")


class PointTable(Table):
    """`[point.<name>]`."""

    link: Text = Field(description="the name of a URDF link")
    xyz: Triple = Field(description="three finite numbers in m, of at most 1e4")


class FamilyTable(Table):
    """`[family.<name>]`."""

    parameter: Text = Field(description="the name of a joint")
    start: Number = Field(alias="from", description=_ANGLE)
    stop: Number = Field(alias="to", description=_ANGLE)
    follow: dict[JointName, Factor] = Field(default={}, description="a table of joint = finite factor")

    @model_validator(mode="after")
    def _runs_forward(self) -> FamilyTable:
        if self.start >= self.stop:
            raise Contradiction("from", shown(self.start), f"less than to, which is {shown(self.stop)}")
        if self.parameter in self.follow:
            key = f"follow.{self.parameter}"
            raise Contradiction(key, "the parameter itself", "other joints that follow it")
        return self


class ObstacleTable(Table):
    """`[obstacle.<name>]`: one of box, sphere, cylinder and mesh, and where it is."""

    box: Annotated[list[Length], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="three lengths in m, above 0"
    )
    sphere: Length | None = Field(default=None, description="a radius in m, above 0")
    cylinder: Annotated[list[Length], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="a radius and a length in m, above 0"
    )
    mesh: Text | None = Field(default=None, description="a path to a mesh, relative to this file or absolute")
    scale: Length = Field(default=1.0, description="metres for each unit of the mesh, above 0")
    xyz: Triple = Field(default=[0.0, 0.0, 0.0], description="three finite numbers in m, of at most 1e4")
    rpy: Triple = Field(default=[0.0, 0.0, 0.0], description="three finite numbers in rad")
    link: str = Field(default="", description="the name of a URDF link; left out, what stands in the world")

    @model_validator(mode="after")
    def _has_one_shape(self) -> ObstacleTable:
        shapes = [name for name in ("box", "sphere", "cylinder", "mesh") if getattr(self, name) is not None]
        if len(shapes) != 1:
            found = " and ".join(shapes) or "no shape"
            raise Contradiction(
                shapes[0] if shapes else "box", found, "one of box, sphere, cylinder and mesh"
            )
        return self


class ToleranceTable(Table):
    """`[tolerance]`: relative standard deviations of what the URDF says of links."""

    mass: Deviation | None = Field(default=None, description=_DEVIATION)
    inertia: Deviation | None = Field(default=None, description=_DEVIATION)


class CardTable(Table):
    """The whole file."""

    format: Literal[1] = Field(description="1")
    name: Name
    title: Text = Field(description=TEXT)
    urdf: Text = Field(description="a path to a URDF: relative to this file, absolute, or package://")
    tool: Text = Field(description="the name of a URDF link")
    source: Text = Field(description=f"{TEXT}: where the numbers come from")
    loss_frequency: Hertz | None = Field(
        default=None,
        description="a number in Hz, from 1e-6 to 1e9, where lossy joints have their stiffness",
    )
    tolerance: ToleranceTable = Field(default=ToleranceTable(), description="a table [tolerance]")
    joint: dict[JointName, JointTable] = Field(min_length=1, description="at least one table [joint.<name>]")
    coupling: dict[Pair, CouplingTable] = Field(default={}, description='tables [coupling."jointA+jointB"]')
    point: dict[Name, PointTable] = Field(default={}, description="tables [point.<name>]")
    srdf: Text | None = Field(
        default=None, description="a path to an SRDF, relative to this file or absolute"
    )
    obstacle: dict[Name, ObstacleTable] = Field(default={}, description="tables [obstacle.<name>]")
    posture: dict[Name, Angles] = Field(default={}, description="tables [posture.<name>]")
    family: dict[Name, FamilyTable] = Field(default={}, description="tables [family.<name>]")
