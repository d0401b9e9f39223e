"""OpenGL without a screen: a chain of backends, the first that draws is used.

OSMesa comes first: it needs no device, and draws on every machine alike. Then EGL on llvmpipe,
Mesa's software driver; then EGL on any other device. A context is used only after it has drawn a
known picture (:mod:`hsr.gl.selftest`).

llvmpipe takes its number of threads from the environment variable ``LP_NUM_THREADS``, when its
first context opens; by default it starts one a processor.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Any, cast

import moderngl

from hsr.base.errors import HsrError, NoOpenGLError
from hsr.gl.drawing import FRAGMENT_SHADER, VERTEX_SHADER
from hsr.gl.loaders import EGL, MAX_EGL_DEVICES, Loader, OSMesa
from hsr.gl.selftest import flaw

SOFTWARE = "llvmpipe"
"""What the name of Mesa's software driver begins with."""


class Context:
    """An OpenGL context, made current by ``with context.gl``.

    Parameters
    ----------
    backend : {"osmesa", "egl"}
    loader : OSMesa or EGL

    Attributes
    ----------
    gl : moderngl.Context
    program : moderngl.Program
        Compiled once, shared by all drawings of the context.
    loader : OSMesa or EGL
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
        If OpenGL is too old, or does not draw the test picture.
    """

    def __init__(self, backend: str, loader: Loader) -> None:
        self.backend, self.loader = backend, loader
        try:
            with loader:
                self.gl = moderngl.create_context(context=cast(Any, loader))
                self.gl.gc_mode = "context_gc"  # what is no longer needed waits for gl.gc()
                self.program = self.gl.program(vertex_shader=VERTEX_SHADER, fragment_shader=FRAGMENT_SHADER)
                self._describe(self.gl.info)
        except (moderngl.Error, ValueError) as error:
            loader.release()
            raise NoOpenGLError(" ".join(str(error).split())) from error
        complaint = flaw(self)
        if complaint:
            self.release()
            raise NoOpenGLError(f"{self.renderer} {complaint}")

    def _describe(self, info: dict[str, Any]) -> None:
        self.renderer, self.version = info["GL_RENDERER"], info["GL_VERSION"]
        self.subpixel_bits = int(info["GL_SUBPIXEL_BITS"])
        self.max_side = int(info["GL_MAX_TEXTURE_SIZE"])

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


def _open_osmesa() -> Context:
    return Context("osmesa", OSMesa())


def _open_egl() -> Context:
    """Walk the EGL devices until one is llvmpipe; without it, take the first that draws."""
    reasons: list[str] = []
    other: Context | None = None
    for device in range(MAX_EGL_DEVICES):
        try:
            context = Context("egl", EGL(device))
        except HsrError as error:
            reasons.append(str(error))
            continue
        if context.renderer.startswith(SOFTWARE):
            if other:
                other.release()
            return context
        if other:
            context.release()
        else:
            other = context
    if other:
        return other
    raise NoOpenGLError(reasons[0])


BACKENDS: dict[str, Callable[[], Context]] = {"osmesa": _open_osmesa, "egl": _open_egl}
"""How each backend opens a context, in the order in which they are tried."""


def open_context(backend: str = "auto") -> Context:
    """Open a context and prove that it draws.

    Every context moderngl makes keeps some 40 kB for good, so a loop of renders should share one:
    :func:`shared_context`.

    Parameters
    ----------
    backend : {"auto", "osmesa", "egl"}
        ``auto`` tries them in this order.

    Returns
    -------
    Context
        To be released by the caller.

    Raises
    ------
    NoOpenGLError
        If none of them draws.
    """
    reasons = []
    for name in BACKENDS if backend == "auto" else (backend,):
        try:
            return BACKENDS[name]()
        except HsrError as error:
            reasons.append(f"{name}: {error}")
    raise NoOpenGLError(f"no OpenGL that draws ({'; '.join(reasons)}); 'hsr doctor' says what to install")


@cache
def shared_context(backend: str = "auto") -> Context:
    """Return the context that all renders of this process share; see :func:`open_context`."""
    return open_context(backend)
