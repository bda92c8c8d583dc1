"""What the schemas of TOML files have in common, for pydantic; imported only while a file is read."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

TEXT = "some text, not empty"
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Metres = Annotated[float, Field(strict=True, ge=-1e4, le=1e4)]
"""No robot reaches ten kilometres."""
Triple = Annotated[list[Metres], Field(min_length=3, max_length=3)]


class Table(BaseModel):
    """A table that has the keys it names and no others."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
