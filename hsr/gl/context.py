"""An OpenGL context that needs no screen; whether it draws as it should is not known here."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any, cast

import moderngl

from hsr.base.errors import NoOpenGLError
from hsr.gl.loaders import Loader

SOFTWARE = "llvmpipe"
"""What the name of Mesa's software driver begins with."""

VERTEX_SHADER = """
#version 330
uniform mat4 clip_from_world;
in vec3 vertex;
void main() { gl_Position = clip_from_world * vec4(vertex, 1.0); }
"""

FRAGMENT_SHADER = """
#version 330
uniform int first;
out int triangle;
void main() { triangle = first + gl_PrimitiveID + 1; }
"""


class Context:
    """An OpenGL context, made current by ``with context.gl``.

    Parameters
    ----------
    backend : {"osmesa", "egl"}
    loader : Loader

    Attributes
    ----------
    gl : moderngl.Context
    loader : Loader
        Finds the functions that moderngl does not have.
    backend, renderer, version : str
        ``osmesa`` or ``egl``, and what OpenGL says of itself.
    subpixel_bits : int
        Corners are rounded to multiples of 2**-subpixel_bits pixels on the screen.
    max_side : int
        Largest image width and height.

    Raises
    ------
    NoOpenGLError
        If OpenGL is too old.
    """

    def __init__(self, backend: str, loader: Loader) -> None:
        self.backend, self.loader = backend, loader
        try:
            with loader:
                self.gl = moderngl.create_context(context=cast(Any, loader))
                self.gl.gc_mode = "context_gc"  # what is no longer needed waits for gl.gc()
                info = self.gl.info
        except (moderngl.Error, ValueError) as error:
            loader.release()
            raise NoOpenGLError(" ".join(str(error).split())) from error
        self.renderer, self.version = info["GL_RENDERER"], info["GL_VERSION"]
        self.subpixel_bits = int(info["GL_SUBPIXEL_BITS"])
        self.max_side = int(info["GL_MAX_TEXTURE_SIZE"])

    @cached_property
    def program(self) -> moderngl.Program:
        """What numbers triangles, compiled once and shared by all drawings; the context must be current."""
        return self.gl.program(vertex_shader=VERTEX_SHADER, fragment_shader=FRAGMENT_SHADER)

    @property
    def threads(self) -> int | None:
        """Threads that llvmpipe draws with; None for other drivers, which do not say."""
        if not self.renderer.startswith(SOFTWARE):
            return None
        asked = os.environ.get("LP_NUM_THREADS", "")
        return int(asked) if asked.isdecimal() else os.cpu_count()

    def release(self) -> None:
        """Destroy the context and all that was uploaded to it."""
        self.gl.release()
