"""What moderngl needs of a window system, for two that need no window: OSMesa and EGL.

A loader finds OpenGL's functions, makes its context current and lets go of it again. moderngl
takes any object that can do this: ``moderngl.create_context(context=loader)``. A context is
current for one thread at a time, so a loader is held by one thread at a time; after ``with`` no
context is current, which lets contexts of both kinds live side by side.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from contextlib import suppress
from ctypes.util import find_library
from threading import Lock
from typing import Any

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


SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "OSMesaCreateContextAttribs": (ctypes.c_void_p, [ctypes.POINTER(ctypes.c_int), ctypes.c_void_p]),
    "OSMesaMakeCurrent": (
        ctypes.c_ubyte,
        [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_int],
    ),
    "OSMesaGetProcAddress": (ctypes.c_void_p, [ctypes.c_char_p]),
    "OSMesaDestroyContext": (None, [ctypes.c_void_p]),
}
"""Of the functions of OSMesa that are called: what they return and take."""


class Loader(ABC):
    """The part of a window system that moderngl uses; one thread at a time holds it."""

    def __init__(self) -> None:
        self._lock = Lock()

    @abstractmethod
    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""

    @abstractmethod
    def take(self) -> None:
        """Make the context current for this thread."""

    @abstractmethod
    def leave(self) -> None:
        """Leave this thread without a context."""

    @abstractmethod
    def release(self) -> None:
        """Destroy the context, which must not be current."""

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


class OSMesa(Loader):
    """A context of Mesa's off-screen library, which draws in memory and needs no device.

    Raises
    ------
    NoOpenGLError
        If the library is missing, or makes no context of :data:`VERSION`.
    """

    def __init__(self) -> None:
        super().__init__()
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

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    def take(self) -> None:
        """Make the context current for this thread."""
        if not self._library.OSMesaMakeCurrent(self._context, self._picture, GL_UNSIGNED_BYTE, 1, 1):
            raise NoOpenGLError("OSMesa refuses to make its context current")

    def leave(self) -> None:
        """Leave this thread without a context."""
        self._library.OSMesaMakeCurrent(None, None, 0, 0, 0)

    def release(self) -> None:
        """Destroy the context, which must not be current."""
        self._library.OSMesaDestroyContext(self._context)


def _osmesa_library() -> ctypes.CDLL:
    library = _first_library([*OSMESA_LIBRARIES, find_library("OSMesa")])
    try:
        for name, (result, parameters) in SIGNATURES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, parameters
    except AttributeError as error:
        raise NoOpenGLError(f"this OSMesa is too old: {error}") from error
    return library


def _first_library(names: list[str | None]) -> ctypes.CDLL:
    for name in filter(None, names):
        with suppress(OSError):
            return ctypes.CDLL(name)
    raise NoOpenGLError(f"{OSMESA_LIBRARIES[0]} is not installed")


class EGL(Loader):
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
        super().__init__()
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

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function of OpenGL, 0 where there is none."""
        return int(self._context.load_opengl_function(name))

    def take(self) -> None:
        """Make the context current for this thread."""
        self._context.__enter__()

    def leave(self) -> None:
        """Leave this thread without a context."""
        self._context.__exit__()

    def release(self) -> None:
        """Destroy the context, which must not be current."""
        self._context.release()
