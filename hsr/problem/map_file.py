"""What the file of a map may hold: the types of all that it tells, and arrays that fit together."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, PositiveFloat, model_validator

from hsr.base.arrays import Array


class Told(BaseModel):
    """Base of what a file tells: strict, no NaN; what is not known is not judged."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class NoDepth(Told, extra="forbid"):
    """The depth format of a map that tells no depths."""

    stored: Literal["nothing"]


class DepthFormat(Told):
    """How depths are stored; see :func:`hsr.problem.map.depth_format`."""

    stored: Literal["window", "linear", "distance"]
    step: PositiveFloat
    near: float
    far: float | None
    perspective: bool

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.stored == "window" and self.perspective and self.near <= 0.0:
            raise ValueError("near must be more than 0")
        if self.far is not None and self.far <= self.near:
            raise ValueError("far must be more than near")
        return self


class Model(Told, extra="allow"):
    """By which model a map was made, and its parameters."""

    __pydantic_extra__: dict[str, str | int | float] = Field(init=False)
    model: str


class Notes(Told):
    """The notes that are read again."""

    depth_format: Annotated[NoDepth | DepthFormat, Field(discriminator="stored")] = NoDepth(stored="nothing")
    model: Model = Model(model="")
    driver: str = ""
    depths: str = ""


class Entry(Told):
    """One object of a manifest."""

    name: str
    shape: str
    first: NonNegativeInt
    count: NonNegativeInt
    faces: list[str] | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.faces and len(self.faces) != self.count:
            raise ValueError(f"{len(self.faces)} names for {self.count} faces")
        return self


class Facts(Told):
    """What the file tells beside the arrays."""

    method: str
    work: dict[str, int | float]
    notes: Notes
    manifest: list[Entry]
    hashes: dict[str, str]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        for one, other in pairwise(self.manifest):
            if other.first < one.first + one.count:
                raise ValueError(f"objects {one.name!r} and {other.name!r} share faces")
        return self


def check_facts(meta: Mapping[str, Any], shown: Array, background: int) -> None:
    """Refuse facts of other types than they are used in, and faces that no object of the manifest has.

    Raises
    ------
    ValueError
        That says which, and why.
    """
    facts = Facts.model_validate(meta)
    last = max((one.first + one.count for one in facts.manifest), default=2**31) - 1
    if shown.min() < background or shown.max() > last:
        raise ValueError(f"faces from {shown.min()} to {shown.max()}; there are those from 0 to {last}")


def ties_of(arrays: Mapping[str, Array], samples: int) -> list[Array]:
    """Return the arrays of the ties of a map with so many samples: none, or sample, start and face.

    Raises
    ------
    ValueError
        If they are not all there, of other types, out of order, or not of this map.
    """
    found = [arrays.get(name) for name in ("tie_sample", "tie_start", "tie_face")]
    there = [array for array in found if array is not None]
    if not there:
        return []
    if [(array.ndim, array.dtype.str[1:]) for array in there] != [(1, "i8"), (1, "i8"), (1, "i4")]:
        raise ValueError("its ties are not all there, or of other types")
    sample, start, face = there
    whole = start.tolist()[:1] == [0] and start[-1] == len(face) and len(start) == len(sample) + 1
    if not whole or (np.diff(start) < 0).any():
        raise ValueError("the faces of its ties do not belong to its samples")
    inside = [0, *sample.tolist()[:1], *sample.tolist()[-1:], samples - 1]
    if inside != sorted(inside) or (np.diff(sample) <= 0).any():
        raise ValueError(f"the samples of its ties are not in order, or not among its {samples}")
    return there
