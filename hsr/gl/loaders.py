"""What moderngl needs of a window system, for two that need no window: OSMesa and EGL.

A loader finds OpenGL's functions, makes its context current and lets go of it again. moderngl
takes any object that can do this: ``moderngl.create_context(context=loader)``. A context is
current for one thread at a time, so a loader is held by one thread at a time; after ``with`` no
context is current, which lets contexts of both kinds live side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from ctypes import CDLL, POINTER, c_char_p, c_int, c_ubyte, c_uint, c_void_p
from ctypes.util import find_library
from dataclasses import dataclass, field
from functools import partial
from threading import Lock
from typing import Any

from glcontext.egl import create_context

from hsr.base.errors import NoOpenGLError

VERSION = (3, 3)
"""The OpenGL version asked for: the first with everything a map of face ids needs."""

MAX_EGL_DEVICES = 16
"""How many EGL devices are tried: glcontext does not say how many there are."""

OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")

EGL_LIBRARIES = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
"""Named with their versions: those without belong to development packages."""

# Values of Mesa's GL/osmesa.h: OSMESA_FORMAT is OSMESA_RGBA, OSMESA_PROFILE is OSMESA_CORE_PROFILE, then
# OSMESA_CONTEXT_MAJOR_VERSION and OSMESA_CONTEXT_MINOR_VERSION.
OSMESA_ATTRIBUTES = (0x22, 0x1908, 0x33, 0x34, 0x36, VERSION[0], 0x37, VERSION[1], 0)
GL_UNSIGNED_BYTE = 0x1401

PROTOTYPES: dict[str, tuple[Any, ...]] = {
    "OSMesaCreateContextAttribs": (c_void_p, POINTER(c_int), c_void_p),
    "OSMesaMakeCurrent": (c_ubyte, c_void_p, c_void_p, c_uint, c_int, c_int),
    "OSMesaGetProcAddress": (c_void_p, c_char_p),
    "OSMesaDestroyContext": (None, c_void_p),
}
"""Result and arguments of the functions of OSMesa that are called."""


@dataclass(frozen=True, eq=False)
class Loader:
    """The part of a window system that moderngl uses, for one context; one thread at a time holds it.

    Attributes
    ----------
    load_opengl_function : callable
        From the name of a function of OpenGL to its address, 0 where there is none.
    take, leave : callable
        Make the context current for this thread, and leave the thread without one.
    release : callable
        Destroys the context, which must not be current.
    """

    load_opengl_function: Callable[[str], int]
    take: Callable[[], object]
    leave: Callable[[], object]
    release: Callable[[], object]
    _lock: Lock = field(default_factory=Lock)

    def __enter__(self) -> Loader:
        self._lock.acquire()
        try:
            self.take()
        except BaseException:
            self._lock.release()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self.leave()
        self._lock.release()


def osmesa() -> Loader:
    """Make a context of Mesa's off-screen library, which draws in memory and needs no device.

    Raises
    ------
    NoOpenGLError
        If the library is missing, or makes no context of :data:`VERSION`.
    """
    library = osmesa_library()
    context = library.OSMesaCreateContextAttribs((c_int * len(OSMESA_ATTRIBUTES))(*OSMESA_ATTRIBUTES), None)
    if not context:
        raise NoOpenGLError("OSMesa makes no context of OpenGL {}.{}".format(*VERSION))
    # A context is made current together with a picture; ours stays unused, one pixel small.
    picture = (c_ubyte * 4)()

    def take() -> None:
        if not library.OSMesaMakeCurrent(context, picture, GL_UNSIGNED_BYTE, 1, 1):
            raise NoOpenGLError("OSMesa refuses to make its context current")

    return Loader(
        lambda name: library.OSMesaGetProcAddress(name.encode()) or 0,
        take,
        partial(library.OSMesaMakeCurrent, None, None, 0, 0, 0),
        partial(library.OSMesaDestroyContext, context),
    )


def osmesa_library() -> CDLL:
    """Load OSMesa, the first that is found."""
    for name in filter(None, (*OSMESA_LIBRARIES, find_library("OSMesa"))):
        with suppress(OSError):
            library = CDLL(name)
            break
    else:
        raise NoOpenGLError(f"{OSMESA_LIBRARIES[0]} is not installed")
    try:
        for name, (result, *parameters) in PROTOTYPES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, parameters
    except AttributeError as error:
        raise NoOpenGLError(f"this OSMesa is too old: {error}") from error
    return library


def egl(device: int) -> Loader:
    """Have glcontext make a context of one of the machine's EGL devices, from 0, without a surface.

    Raises
    ------
    NoOpenGLError
        If the libraries or the device are missing, or it makes no context of :data:`VERSION`.
    """
    version = 100 * VERSION[0] + 10 * VERSION[1]
    try:
        context = create_context(mode="standalone", glversion=version, device_index=device, **EGL_LIBRARIES)
    except Exception as error:  # glcontext raises no narrower class
        raise NoOpenGLError(str(error)) from error
    context.__exit__()  # glcontext leaves a new context current
    return Loader(context.load_opengl_function, context.__enter__, context.__exit__, context.release)
