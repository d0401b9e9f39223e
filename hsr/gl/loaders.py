"""What moderngl needs of a window system, for two that need no window: OSMesa and EGL.

A loader finds OpenGL's functions, makes its context current and lets go of it again. moderngl
takes any object that can do this: ``moderngl.create_context(context=loader)``. A context is
current for one thread at a time, so a loader is held by one thread at a time; after ``with`` no
context is current, which lets contexts of both kinds live side by side.
"""

from __future__ import annotations

import ctypes
from ctypes.util import find_library
from threading import Lock
from typing import Protocol

from glcontext import egl

from hsr.base.errors import NoOpenGLError

VERSION = (3, 3)
"""The OpenGL version asked for: the first with everything a map of face ids needs."""

MAX_EGL_DEVICES = 16
"""How many EGL devices are tried: glcontext does not say how many there are."""

OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")

# Names and values of Mesa's GL/osmesa.h.
OSMESA_FORMAT, OSMESA_RGBA = 0x22, 0x1908
OSMESA_PROFILE, OSMESA_CORE_PROFILE = 0x33, 0x34
OSMESA_CONTEXT_MAJOR_VERSION, OSMESA_CONTEXT_MINOR_VERSION = 0x36, 0x37
GL_UNSIGNED_BYTE = 0x1401


class Loader(Protocol):
    """The part of a window system that moderngl uses."""

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""

    def __enter__(self) -> object:
        """Make the context current for this thread."""

    def __exit__(self, *exception: object) -> None:
        """Leave this thread without a context."""

    def release(self) -> None:
        """Destroy the context, which must not be current."""


class OSMesa:
    """A context of Mesa's off-screen library, which draws in memory and needs no device.

    Raises
    ------
    NoOpenGLError
        If the library is missing, or makes no context of :data:`VERSION`.
    """

    def __init__(self) -> None:
        self._library = _osmesa_library()
        attributes = (
            *(OSMESA_FORMAT, OSMESA_RGBA),
            *(OSMESA_PROFILE, OSMESA_CORE_PROFILE),
            *(OSMESA_CONTEXT_MAJOR_VERSION, VERSION[0]),
            *(OSMESA_CONTEXT_MINOR_VERSION, VERSION[1]),
            0,
        )
        array = (ctypes.c_int * len(attributes))(*attributes)
        self._context = self._library.OSMesaCreateContextAttribs(array, None)
        if not self._context:
            raise NoOpenGLError("OSMesa makes no context of OpenGL {}.{}".format(*VERSION))
        # A context is made current together with a picture; ours stays unused, one pixel small.
        self._picture = (ctypes.c_ubyte * 4)()
        self._lock = Lock()

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    def __enter__(self) -> OSMesa:
        """Make the context current for this thread."""
        self._lock.acquire()
        if not self._library.OSMesaMakeCurrent(self._context, self._picture, GL_UNSIGNED_BYTE, 1, 1):
            self._lock.release()
            raise NoOpenGLError("OSMesa refuses to make its context current")
        return self

    def __exit__(self, *exception: object) -> None:
        """Leave this thread without a context."""
        self._library.OSMesaMakeCurrent(None, None, 0, 0, 0)
        self._lock.release()

    def release(self) -> None:
        """Destroy the context, which must not be current."""
        self._library.OSMesaDestroyContext(self._context)


def _osmesa_library() -> ctypes.CDLL:
    library = _first_library([*OSMESA_LIBRARIES, find_library("OSMesa")])
    try:
        library.OSMesaCreateContextAttribs.restype = ctypes.c_void_p
        library.OSMesaCreateContextAttribs.argtypes = [ctypes.POINTER(ctypes.c_int), ctypes.c_void_p]
        library.OSMesaMakeCurrent.restype = ctypes.c_ubyte
        library.OSMesaMakeCurrent.argtypes = [
            *(ctypes.c_void_p, ctypes.c_void_p),
            *(ctypes.c_uint, ctypes.c_int, ctypes.c_int),
        ]
        library.OSMesaGetProcAddress.restype = ctypes.c_void_p
        library.OSMesaGetProcAddress.argtypes = [ctypes.c_char_p]
        library.OSMesaDestroyContext.restype = None
        library.OSMesaDestroyContext.argtypes = [ctypes.c_void_p]
    except AttributeError as error:
        raise NoOpenGLError(f"this OSMesa is too old: {error}") from error
    return library


def _first_library(names: list[str | None]) -> ctypes.CDLL:
    for name in filter(None, names):
        try:
            return ctypes.CDLL(name)
        except OSError:
            continue
    raise NoOpenGLError(f"{OSMESA_LIBRARIES[0]} is not installed")


class EGL:
    """A context of one EGL device, without a surface; glcontext makes it.

    The libraries are named with their versions: those without belong to development packages.

    Parameters
    ----------
    device : int
        Which of the machine's EGL devices, from 0.

    Raises
    ------
    NoOpenGLError
        If the libraries or the device are missing, or it makes no context of :data:`VERSION`.
    """

    def __init__(self, device: int) -> None:
        try:
            self._context = egl.create_context(
                mode="standalone",
                libgl="libGL.so.1",
                libegl="libEGL.so.1",
                glversion=100 * VERSION[0] + 10 * VERSION[1],
                device_index=device,
            )
        except Exception as error:  # glcontext raises no narrower class
            raise NoOpenGLError(str(error)) from error
        self._context.__exit__()  # glcontext leaves a new context current
        self._lock = Lock()

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""
        return int(self._context.load_opengl_function(name))

    def __enter__(self) -> EGL:
        """Make the context current for this thread."""
        self._lock.acquire()
        self._context.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        """Leave this thread without a context."""
        self._context.__exit__()
        self._lock.release()

    def release(self) -> None:
        """Destroy the context, which must not be current."""
        self._context.release()
