"""The values of a scene file's keys: numbers and texts, checked, and the base of its tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Annotated, Any, Self, TypeVar

from flint import fmpq, fmpq_mat
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    model_validator,
)


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _exactly(count: int, what: str = "numbers") -> BeforeValidator:
    """Take a list of this length for a tuple."""

    def check(value: Any) -> Any:
        if isinstance(value, list | tuple) and len(value) != count:
            raise ValueError(f"expected {count} {what}, got {len(value)}")
        return _as_tuple(value)

    return BeforeValidator(check)


def _thrice(value: Any) -> Any:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return (value, value, value) if is_number else value


NUMBER: dict[str, Any] = {"type": "number"}
ONE_OR_THREE = {"anyOf": [NUMBER, {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}]}


def _that(holds: Callable[[Any], object], otherwise: str) -> AfterValidator:
    """Refuse a value of which something does not hold."""

    def check(value: Any) -> Any:
        if not holds(value):
            raise ValueError(otherwise)
        return value

    return AfterValidator(check)


def exact_determinant(matrix: Any) -> Fraction:
    """Return the determinant of a square matrix of floats, without rounding.

    >>> exact_determinant([[1.0, 2.0], [0.5, 1.0]])
    Fraction(0, 1)
    """
    determinant = fmpq_mat([[fmpq(*x.as_integer_ratio()) for x in row] for row in matrix]).det()
    return Fraction(int(determinant.p), int(determinant.q))


def unit(vector: Any) -> list[float]:
    """Scale to length 1, unless it is 0; ``hypot`` neither over- nor underflows on the way."""
    length = math.hypot(*vector)
    return [x / length if length else 0.0 for x in vector]


Entry = TypeVar("Entry")
List = Annotated[tuple[Entry, ...], BeforeValidator(_as_tuple)]
Vector = Annotated[tuple[float, float, float], _exactly(3)]
Direction = Annotated[Vector, _that(any, "a direction of length 0 points nowhere")]
Regular = _that(all, "a scale of 0 makes the transform singular")
Scale = Annotated[Vector, BeforeValidator(_thrice), Regular, WithJsonSchema(ONE_OR_THREE)]
Row = Annotated[tuple[float, float, float, float], _exactly(4)]
Matrix = Annotated[tuple[Row, Row, Row, Row], _exactly(4, "rows")]
Invertible = Annotated[Matrix, _that(exact_determinant, "the matrix is singular: it flattens the world")]
Affine = Annotated[
    Matrix,
    _that(lambda rows: rows[3] == (0.0, 0.0, 0.0, 1.0), "the last row of an affine matrix is [0, 0, 0, 1]"),
    _that(exact_determinant, "the matrix is singular: it flattens the object"),
]
Channel = Annotated[float, Field(ge=0.0, le=1.0)]
Colour = Annotated[tuple[Channel, Channel, Channel], _exactly(3)]
Loop = Annotated[List[int], Field(min_length=3)]
Pair = Annotated[tuple[float, float], _exactly(2)]
Printable = _that(str.isprintable, "expected printable characters")
Name = Annotated[str, Field(min_length=1, max_length=80), Printable]


class Description(BaseModel):
    """Base of every part of a scene file: frozen, strict, no unknown key, no NaN."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        self._check()
        return self

    def _check(self) -> None:
        """Raise a ``ValueError`` if values that are right by themselves do not fit together."""
