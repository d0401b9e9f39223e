"""OpenGL as a method: what the driver of this machine sees of a view.

The map is the driver's own: float32 vertices and matrix, corners snapped to its sub-pixel grid, a
depth buffer of 24 bits unless another is asked for. See :mod:`hsr.gl.drawing` for how it is drawn, and
:mod:`hsr.gl.backends` for which driver draws, and with how many threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr.algorithms.prepare import choices
from hsr.gl.backends import BACKENDS, shared_context
from hsr.gl.context import Context
from hsr.gl.depth import DEPTH_BUFFERS, DepthBuffer
from hsr.gl.drawing import Drawing
from hsr.problem.map import Clock, VisibilityMap, depth_format
from hsr.problem.view import View


@dataclass(frozen=True)
class Options:
    """How OpenGL is reached.

    Attributes
    ----------
    backend : {"auto", "osmesa", "egl"}
        ``auto`` takes the first that draws.
    depth_format : {"d24", "d16", "d32f", "d32f-reversed", "d32f-reversed-ndc"}
        What the depth buffer holds: integers of so many bits, or float32. ``reversed`` is 1 at near and 0
        at far, the greater is the nearer, and normalised depth runs from 0 to 1, which needs the driver's
        ``glClipControl``; with ``ndc`` it runs from 1 to -1 and is moved to [0, 1] afterwards.
    """

    backend: str = "auto"
    depth_format: str = "d24"

    def __post_init__(self) -> None:
        known = {"backend": ("auto", *BACKENDS), "depth_format": DEPTH_BUFFERS}
        choices.check("opengl", self, known)

    @property
    def buffer(self) -> DepthBuffer:
        """The depth buffer."""
        return DEPTH_BUFFERS[self.depth_format]


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
        ``seconds``: ``prepare`` uploads the triangles, once a scene, ``render`` clears, draws and waits,
        ``read`` brings the answer back. Opening the driver, once a process, is not counted.
        ``work``: ``triangles`` and ``vertices`` drawn.

    Raises
    ------
    UnavailableError
        If no backend draws.
    MethodError
        If the view is beyond the driver's limits.
    """
    context = shared_context(options.backend)
    with context.gl as gl:
        gl.gc()  # what scenes left behind that are gone; not counted
    clock = Clock()
    with clock("prepare"):
        drawing = Drawing(context, view, options.buffer)
    with drawing:
        with clock("render"):
            drawing.draw()
        with clock("read"):
            face, depth = drawing.read()
    work = {"triangles": drawing.triangles, "vertices": drawing.vertices}
    return VisibilityMap(face, depth, "opengl", work, clock.seconds, _notes(context, view, options.buffer))


def _notes(context: Context, view: View, buffer: DepthBuffer) -> dict[str, Any]:
    return {
        "driver": f"{context.renderer}; {context.version}",
        "backend": context.backend,
        "subpixel_bits": context.subpixel_bits,
        "threads": context.threads,
        "depth_format": depth_format("window", buffer.step, view.near, view.far, view.perspective),
    }
