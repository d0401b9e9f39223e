"""The formats in which OpenGL keeps depths, and the matrix that each of them wants.

Window depth is 0 at near and 1 at far. Reversed it is 1 at near and 0 at far, the greater is the nearer, and
floats, which are dense near 0, are dense where window depth is crowded. But OpenGL's normalised depth runs
from -1 to 1, and is halved and moved by a half on its way to the buffer; only ``glClipControl`` (OpenGL 4.5)
lets it run from 0 to 1 instead.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import moderngl

from hsr.base.arrays import Floats
from hsr.base.errors import NoOpenGLError
from hsr.gl.context import Context
from hsr.problem.view import View

# Names and values of OpenGL's own header.
GL_TEXTURE_2D, GL_DEPTH_COMPONENT, GL_FLOAT = 0x0DE1, 0x1902, 0x1406
GL_DEPTH_COMPONENT16, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT32F = 0x81A5, 0x81A6, 0x8CAC
GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE, GL_ZERO_TO_ONE = 0x8CA1, 0x935E, 0x935F


@dataclass(frozen=True)
class DepthBuffer:
    """A format of depths.

    Attributes
    ----------
    internal : int
        OpenGL's number of the format, to make a texture of it.
    bits : int
        Of the integers that are stored, counted from near to far; 0 if floats are.
    reversed : bool
        Whether 1 is near and 0 far, and the greater is shown.
    zero_to_one : bool
        Whether normalised depth runs from 0 to 1, not from -1 to 1.
    """

    internal: int
    bits: int = 0
    reversed: bool = False
    zero_to_one: bool = False

    @property
    def step(self) -> float:
        """Distance of neighbouring stored depths, of floats the greatest there is."""
        return 1.0 / (2**self.bits - 1) if self.bits else 2.0**-24

    @property
    def cleared_to(self) -> float:
        """What stands in the buffer before anything is drawn."""
        return 0.0 if self.reversed else 1.0

    def clip_from_world(self, view: View) -> Floats:
        """Return the matrix (4, 4) of a view, its row for z such that depths come out as stored here."""
        matrix = view.clip_from_world.copy()
        if self.reversed:
            z, w = matrix[2:]
            matrix[2] = 0.5 * (w - z) if self.zero_to_one else -z
        return matrix


D24 = DepthBuffer(GL_DEPTH_COMPONENT24, 24)

DEPTH_BUFFERS = {
    "d16": DepthBuffer(GL_DEPTH_COMPONENT16, 16),
    "d24": D24,
    "d32f": DepthBuffer(GL_DEPTH_COMPONENT32F),
    "d32f-reversed": DepthBuffer(GL_DEPTH_COMPONENT32F, reversed=True, zero_to_one=True),
    "d32f-reversed-ndc": DepthBuffer(GL_DEPTH_COMPONENT32F, reversed=True),
}
"""The formats by name; ``ndc`` goes through [-1, 1]."""


def depth_texture(context: Context, size: tuple[int, int], buffer: DepthBuffer) -> moderngl.Texture:
    """Make a depth texture of a format, in a context that is current."""
    texture = context.gl.depth_texture(size)
    if buffer.internal != GL_DEPTH_COMPONENT24:  # moderngl makes no other
        make = _function(context, "glTexImage2D", *[ctypes.c_int] * 8, ctypes.c_void_p)
        texture.use()
        make(GL_TEXTURE_2D, 0, buffer.internal, *size, 0, GL_DEPTH_COMPONENT, GL_FLOAT, None)
    return texture


@contextmanager
def clip_range(context: Context, buffer: DepthBuffer) -> Iterator[None]:
    """Let normalised depth run as the buffer has it, in a context that is current.

    Raises
    ------
    NoOpenGLError
        If the driver has no ``glClipControl``.
    """
    if not buffer.zero_to_one:
        yield
        return
    if "GL_ARB_clip_control" not in context.gl.extensions:
        raise NoOpenGLError(f"{context.renderer} has no glClipControl, which depths from 0 to 1 need")
    control = _function(context, "glClipControl", ctypes.c_uint, ctypes.c_uint)
    control(GL_LOWER_LEFT, GL_ZERO_TO_ONE)
    try:
        yield
    finally:
        control(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE)


def _function(context: Context, name: str, *parameters: Any) -> Callable[..., None]:
    """Return a function of OpenGL that moderngl does not have."""
    return ctypes.CFUNCTYPE(None, *parameters)(context.loader.load_opengl_function(name))
