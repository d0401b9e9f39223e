"""What the file of a map may hold: the types of all that it tells, and arrays that fit together."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, PositiveFloat, model_validator

from hsr.base.arrays import Array, Ints
from hsr.problem.map import BACKGROUND, Admissible


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


def check_facts(meta: Mapping[str, Any], face: Ints, ties: Admissible | None) -> None:
    """Refuse facts of other types than they are used in, and faces that no object of the manifest has.

    Raises
    ------
    ValueError
        That says which, and why.
    """
    facts = Facts.model_validate(meta)
    last = max((one.first + one.count for one in facts.manifest), default=2**31) - 1
    for shown in [face] if ties is None else [face, ties.face]:
        if shown.size and not (shown.min() >= BACKGROUND and shown.max() <= last):
            raise ValueError(f"faces from {shown.min()} to {shown.max()}; there are those from 0 to {last}")


def ties_of(arrays: Mapping[str, Array], samples: int) -> Admissible | None:
    """Return the ties among the arrays of a file, if there are any.

    Raises
    ------
    ValueError
        If they are not all there, of other types, out of order, or not of this map.
    """
    found = [arrays.get(f"tie_{name}") for name in Admissible._fields]
    if all(array is None for array in found):
        return None
    kinds = [(None, None) if array is None else (array.ndim, array.dtype.str[1:]) for array in found]
    if kinds != [(1, "i8"), (1, "i8"), (1, "i4")]:
        raise ValueError("its ties are not all there, or of other types")
    ties = Admissible(*(array for array in found if array is not None))
    whole = ties.start.tolist()[:1] == [0] and ties.start[-1] == len(ties.face)
    if not whole or len(ties.start) != len(ties.sample) + 1 or (np.diff(ties.start) < 0).any():
        raise ValueError("the faces of its ties do not belong to its samples")
    inside = [0, *ties.sample.tolist()[:1], *ties.sample.tolist()[-1:], samples - 1]
    if inside != sorted(inside) or (np.diff(ties.sample) <= 0).any():
        raise ValueError(f"the samples of its ties are not in order, or not among its {samples}")
    return ties
