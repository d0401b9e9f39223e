"""OpenGL without a screen: a chain of backends, the first that draws is used.

OSMesa comes first: it needs no device, and draws on every machine alike. Then EGL on llvmpipe,
Mesa's software driver; then EGL on any other device. A context is used only after it has drawn a
known picture (:mod:`hsr.gl.selftest`), and no driver is loaded that ends another process which does the
same (:mod:`hsr.gl.apart`).

llvmpipe takes its number of threads from the environment variable ``LP_NUM_THREADS``, when its
first context opens; by default it starts one a processor.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import moderngl

from hsr.base.errors import HsrError, NoOpenGLError
from hsr.gl.apart import check_survives
from hsr.gl.context import SOFTWARE, Context
from hsr.gl.loaders import MAX_EGL_DEVICES, Loader, egl, osmesa
from hsr.gl.selftest import flaw


def _proven(backend: str, loader: Loader) -> Context:
    """Make a context, and have it draw the test picture."""
    context = Context(backend, loader)
    try:
        complaint = flaw(context)
    except moderngl.Error as error:
        complaint = f"refuses: {' '.join(str(error).split())}"
    if complaint:
        context.release()
        raise NoOpenGLError(f"{context.renderer} {complaint}")
    return context


def _open_egl() -> Context:
    """Walk the EGL devices until one is llvmpipe; without it, take the first that draws."""
    reasons: list[str] = []
    other: Context | None = None
    for device in range(MAX_EGL_DEVICES):
        try:
            context = _proven("egl", egl(device))
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


BACKENDS: dict[str, Callable[[], Context]] = {"osmesa": lambda: _proven("osmesa", osmesa()), "egl": _open_egl}
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
            check_survives(name)
            return BACKENDS[name]()
        except HsrError as error:
            reasons.append(f"{name}: {error}")
    raise NoOpenGLError(f"no OpenGL that draws ({'; '.join(reasons)}); 'hsr doctor' says what to install")


@cache
def shared_context(backend: str = "auto") -> Context:
    """Return the context that all renders of this process share; see :func:`open_context`."""
    return open_context(backend)
