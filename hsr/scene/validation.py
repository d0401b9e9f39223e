"""From what validation found wrong to lines that people can act on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from hsr.base.errors import nearest
from hsr.scene.model import Camera, Light, Object, Scatter, Scene, Step

TAGGED = {"camera": (Camera, "type"), "object": (Object, "shape"), "light": (Light, "type")}
"""The lists whose tables come in several kinds, and the key that says which."""

EXPECTED = {
    "finite_number": "expected a finite number",
    "float_type": "expected a number",
    "int_type": "expected a whole number",
    "string_type": "expected a string",
    "tuple_type": "expected a list",
    "model_type": "expected a table",
    "model_attributes_type": "expected a table",
    "literal_error": "expected {expected}",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "string_too_short": "must have at least {min_length} character",
    "string_too_long": "must have at most {max_length} characters",
    "too_short": "needs at least {min_length}",
}
"""What pydantic calls a mistake, and what we say was expected instead."""


def lines_of(error: ValidationError) -> list[str]:
    """Turn a failed validation into one line a problem.

    Parameters
    ----------
    error : ValidationError
        Of ``Scene.model_validate``, or of a part of a scene.

    Returns
    -------
    list of str
        ``object[2].transform[0].scale: expected a number, got 'big'``; indices count from 0.
    """
    return [_line(detail) for detail in error.errors(include_url=False)]


def shown(value: object) -> str:
    """Return a value as it may stand in a line: short."""
    text = "a table" if isinstance(value, dict) else repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _line(detail: ErrorDetails) -> str:
    path, what = _path(detail), _what(detail)
    return f"{path}: {what}" if path else what


def _path(detail: ErrorDetails) -> str:
    """Write the keys, without the kind that pydantic adds after ``object[k]``: it is no key of the file."""
    keys = list(detail["loc"])
    if keys and keys[0] in TAGGED:
        del keys[2:3]
    if detail["type"] == "union_tag_invalid":
        keys.append(TAGGED[str(keys[0])][1])
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")


def _what(detail: ErrorDetails) -> str:
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "missing":
        return "this key is missing"
    if kind == "extra_forbidden":
        known = list(_model_at(detail["loc"]).model_fields)
        return f"unknown key; {nearest(detail['loc'][-1], known)}the keys here are {', '.join(known)}"
    if kind.startswith("union_tag"):
        return _wrong_tag(detail)
    if kind not in EXPECTED:
        return f"{detail['msg']}, got {shown(value)}"
    return f"{EXPECTED[kind].format(**context)}, got {shown(value)}"


def _wrong_tag(detail: ErrorDetails) -> str:
    union, key = TAGGED[str(detail["loc"][0])]
    tags = list(_members(union))
    listed = f"known are {', '.join(tags)}"
    if detail["type"] == "union_tag_not_found":
        return f"the key {key!r} is missing; {listed}"
    tag = detail["ctx"]["tag"]
    return f"there is no {key} {shown(tag)}; {nearest(tag, tags)}{listed}"


def _members(union: Any) -> dict[str, type[BaseModel]]:
    """Models of a tagged union by their tag, in order."""
    key = get_args(union)[1].discriminator
    members = get_args(get_args(union)[0])
    return {get_args(member.model_fields[key].annotation)[0]: member for member in members}


def _model_at(loc: Sequence[int | str]) -> type[BaseModel]:
    """Return the model whose table holds the last key of ``loc``."""
    if len(loc) == 1:
        return Scene
    if "transform" in loc:
        return Step
    if "scatter" in loc[:-1]:
        return Scatter
    return _members(TAGGED[str(loc[0])][0])[str(loc[2])]
