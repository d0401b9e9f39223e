"""Which models are those of a renderer from outside, whose pictures come as ids.

=========  ============================================================================================
Model      What it takes the renderer to round
=========  ============================================================================================
exact      nothing: curved shapes have become polygons
opengl     what Mesa's llvmpipe rounds: float32 throughout, corners on 1/256 pixel
float32    corners on the screen and everything after them to float32, depths evaluated at each sample
float64    the same to float64
=========  ============================================================================================

Every method that has models of its own is a model, too, such as ``embree`` or ``raycast-moller-trumbore``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hsr.algorithms.registry import Method, methods
from hsr.base.errors import MapError, nearest
from hsr.problem.map import VisibilityMap

MODEL = "model"
"""The note of a map that says by which model it was made, and with which parameters."""

PARAMETERS = ("subpixel_bits", "depth_format", "fill_rule")
"""What a renderer may have chosen in another way: see ``hsr.algorithms.scanline.Options``."""

CANDIDATES: tuple[dict[str, Any], ...] = (
    {MODEL: "exact"},
    {MODEL: "opengl"},
    {MODEL: "opengl", "depth_format": "d16"},
    {MODEL: "float32"},
    {MODEL: "float32", "subpixel_bits": 8},
    {MODEL: "float32", "subpixel_bits": 4},
    {MODEL: "float32", "depth_format": "d16"},
)
"""What is tried, in this order, where nothing says how a map was made."""


def models() -> dict[str, Method]:
    """Return all models by name: rows whose pipelines put wrong samples down to causes."""
    known = methods()
    direct = {"stepping": "direct"}
    named = {
        "exact": replace(known["zbuffer"], name="exact"),
        "float32": replace(known["scanline"], name="float32", settings=direct | {"arithmetic": "float32"}),
        "float64": replace(known["scanline"], name="float64", settings=direct),
    }
    return named | {name: row for name, row in known.items() if row.pipeline}


def modelled(map: VisibilityMap, model: str, **parameters: Any) -> VisibilityMap:
    """Say by which model a map was made, for all who ask for the causes of its wrong samples.

    Parameters
    ----------
    map : VisibilityMap
        By a renderer from outside.
    model : str
        ``"exact"``, ``"opengl"``, ``"float32"``, ``"float64"``, or a method that has models.
    **parameters
        What the renderer has chosen in another way than the model: ``depth_format`` (``"d16"``, ``"d24"``,
        ``"d32f"``, ...); with float32 and float64 also ``subpixel_bits`` (4, 8 or 12, the grid of corners)
        and ``fill_rule`` (who owns a sample on an edge: ``"top-left"`` or ``"bottom-left"``). Those that are
        None are left out.

    Returns
    -------
    VisibilityMap
        With the note ``model``.

    Raises
    ------
    MapError
        If there is no such model.
    MethodError
        If the model does not have such a parameter, or refuses its value.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.testing import from_ids, modelled
    >>> modelled(from_ids(np.array([[0, 1]])), "float32", subpixel_bits=4).notes["model"]
    {'model': 'float32', 'subpixel_bits': 4}
    """
    known = models()
    if model not in known:
        short = ", ".join(name for name in known if "-" not in name)
        raise MapError(f"there is no model {model!r}; {nearest(model, known)}models are {short} and variants")
    chosen = {name: value for name, value in parameters.items() if value is not None}
    known[model].options(**chosen)
    return replace(map, notes=map.notes | {MODEL: {MODEL: model, **chosen}})


def model_of(map: VisibilityMap) -> tuple[Method | None, dict[str, Any]]:
    """Return the row whose models are those of a map, its method's unless it notes others, and options."""
    told = dict(map.notes.get(MODEL, {MODEL: None}))
    name = told.pop(MODEL)
    return (models().get(name), told) if name else (methods().get(map.method), {})


def has_model(map: VisibilityMap) -> bool:
    """Tell whether a map notes its model, or is by a method that has models of its own."""
    method = model_of(map)[0]
    return bool(method and method.pipeline)


def told_of(map: VisibilityMap) -> str:
    """Write the model that a map notes: ``float32, subpixel_bits 4``; empty if it notes none."""
    told = dict(map.notes.get(MODEL, {MODEL: ""}))
    return ", ".join([told.pop(MODEL), *(f"{what} {value}" for what, value in told.items())])
