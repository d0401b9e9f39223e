"""OpenGL as a method: what the driver of this machine sees of a view.

The map is the driver's own: float32 vertices and matrix, corners snapped to its sub-pixel grid, a
depth buffer of 24 bits. See :mod:`hsr.opengl.drawing` for how it is drawn, and
:mod:`hsr.opengl.contexts` for which driver draws, and with how many threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr.errors import MethodError
from hsr.opengl.contexts import BACKENDS, Context, shared_context
from hsr.opengl.drawing import DEPTH_STEP, Drawing
from hsr.viewing import View
from hsr.visibility import Clock, VisibilityMap, depth_format


@dataclass(frozen=True)
class Options:
    """How OpenGL is reached.

    Attributes
    ----------
    backend : {"auto", "osmesa", "egl"}
        ``auto`` takes the first that draws.
    """

    backend: str = "auto"

    def __post_init__(self) -> None:
        known = ("auto", *BACKENDS)
        if self.backend not in known:
            raise MethodError(f"opengl has no backend {self.backend!r}; choose from {', '.join(known)}")


def render(view: View, options: Options) -> VisibilityMap:
    """Draw a view with OpenGL.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    options : Options

    Returns
    -------
    VisibilityMap
        ``seconds``: ``prepare`` uploads the triangles, ``render`` clears, draws and waits, ``read``
        brings the answer back. Opening the driver, once a process, is not counted.
        ``work``: ``triangles`` and ``vertices`` drawn.

    Raises
    ------
    UnavailableError
        If no backend draws.
    MethodError
        If the view is beyond the driver's limits.
    """
    context = shared_context(options.backend)
    clock = Clock()
    with clock("prepare"):
        drawing = Drawing(context, view)
    with drawing:
        with clock("render"):
            drawing.draw()
        with clock("read"):
            face, depth = drawing.read()
    work = {"triangles": drawing.triangles, "vertices": drawing.vertices}
    return VisibilityMap(face, depth, "opengl", work, clock.seconds, _notes(context, view))


def _notes(context: Context, view: View) -> dict[str, Any]:
    return {
        "driver": f"{context.renderer}; {context.version}",
        "backend": context.backend,
        "subpixel_bits": context.subpixel_bits,
        "threads": context.threads,
        "depth_format": depth_format("window", DEPTH_STEP, view.near, view.far, view.perspective),
    }
