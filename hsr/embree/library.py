"""Embree called directly: the shared library inside the embreex package, through ctypes.

embreex's own API hands over one ray after another on one thread. The library itself takes packets of 16
rays that it may treat as coherent, from as many threads as ask it, and sorts triangles on several threads.
Names that begin with ``rtc`` or ``RTC`` are Embree's; see its API reference.
"""

from __future__ import annotations

import ctypes
import weakref
from ctypes import c_char_p, c_int, c_size_t, c_ssize_t, c_uint, c_void_p
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from typing import Any

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MethodError, UnavailableError
from hsr.embree.packets import PACKET_SIDE, SHARES, Sight, packets_of, trace

VERSION = "4.4"
"""The version whose records :mod:`hsr.embree.packets` knows."""

DEVICE_PROPERTY_VERSIONS = (1, 2, 3)
"""Numbers of the device's properties major, minor and patch version."""

ERRORS = {1: "unknown error", 2: "invalid argument", 3: "invalid operation", 4: "out of memory"}

GEOMETRY_TYPE_TRIANGLE = 0
BUFFER_TYPE_INDEX, BUFFER_TYPE_VERTEX = 0, 1
FORMAT_UINT3, FORMAT_FLOAT3 = 0x5003, 0x9003
BUILD_QUALITY_MEDIUM = 1
SCENE_FLAG_ROBUST = 1 << 2
RAY_QUERY_FLAG_COHERENT = 1 << 16
FEATURE_FLAG_ALL = -1

TRACED = -1
"""In the mask of a packet: this ray is to be traced."""

PROTOTYPES: dict[str, tuple[Any, ...]] = {
    "rtcNewDevice": (c_void_p, c_char_p),
    "rtcGetDeviceProperty": (c_ssize_t, c_void_p, c_int),
    "rtcGetDeviceError": (c_int, c_void_p),
    "rtcNewScene": (c_void_p, c_void_p),
    "rtcSetSceneFlags": (None, c_void_p, c_int),
    "rtcSetSceneBuildQuality": (None, c_void_p, c_int),
    "rtcNewGeometry": (c_void_p, c_void_p, c_int),
    "rtcSetNewGeometryBuffer": (c_void_p, c_void_p, c_int, c_uint, c_int, c_size_t, c_size_t),
    "rtcCommitGeometry": (None, c_void_p),
    "rtcAttachGeometry": (c_uint, c_void_p, c_void_p),
    "rtcReleaseGeometry": (None, c_void_p),
    "rtcCommitScene": (None, c_void_p),
    "rtcReleaseScene": (None, c_void_p),
    "rtcIntersect1": (None, c_void_p, c_void_p, c_void_p),
    "rtcIntersect16": (None, c_void_p, c_void_p, c_void_p, c_void_p),
}
"""Result and arguments of the functions that are called."""


@cache
def library() -> ctypes.CDLL:
    """Load the library.

    Raises
    ------
    UnavailableError
        If embreex is not installed, or does not hold what is called here.
    """
    try:
        found = [file for file in files("embreex") or () if "embree4" in file.name]
        loaded = ctypes.CDLL(str(found[0].locate()))
        for name, (result, *arguments) in PROTOTYPES.items():
            function = getattr(loaded, name)
            function.restype, function.argtypes = result, arguments
    except (PackageNotFoundError, IndexError, OSError, AttributeError) as error:
        raise UnavailableError(
            f"no library of Embree 4 in the package embreex ({error}); pip install 'hsr-lab[embree]'"
        ) from error
    return loaded


@cache
def device(threads: int) -> int:
    """Return the address of a device that builds on a number of threads; kept as long as the process.

    Raises
    ------
    UnavailableError
        If there is no library, it is of another version, or it does not support this processor.
    """
    made = library().rtcNewDevice(f"threads={threads}".encode())
    if made is None:
        raise UnavailableError("Embree does not support this processor; use another method")
    found = version(made)
    if found.split(".")[:2] != VERSION.split("."):
        raise UnavailableError(
            f"embreex holds Embree {found}, but only {VERSION} is known here; install another embreex"
        )
    return int(made)


def version(device: int) -> str:
    """Return the version of the library: ``4.4.0``."""
    return ".".join(str(library().rtcGetDeviceProperty(device, k)) for k in DEVICE_PROPERTY_VERSIONS)


class Scene:
    """Triangles, sorted into Embree's hierarchy.

    Parameters
    ----------
    device : int
    vertices : (V, 3) float32
    corner : (n, 3) int32

    Raises
    ------
    MethodError
        If Embree cannot build it.
    """

    def __init__(self, device: int, vertices: Array, corner: Ints) -> None:
        rtc = library()
        self.address = rtc.rtcNewScene(device)
        weakref.finalize(self, rtc.rtcReleaseScene, self.address)
        rtc.rtcSetSceneFlags(self.address, SCENE_FLAG_ROBUST)
        rtc.rtcSetSceneBuildQuality(self.address, BUILD_QUALITY_MEDIUM)
        geometry = rtc.rtcNewGeometry(device, GEOMETRY_TYPE_TRIANGLE)
        _copy(geometry, BUFFER_TYPE_VERTEX, FORMAT_FLOAT3, vertices)
        _copy(geometry, BUFFER_TYPE_INDEX, FORMAT_UINT3, corner)
        rtc.rtcCommitGeometry(geometry)
        rtc.rtcAttachGeometry(self.address, geometry)
        rtc.rtcReleaseGeometry(geometry)
        rtc.rtcCommitScene(self.address)
        _check(device)

    def trace(self, sight: Sight, packets: bool, face_of: Ints, size: tuple[int, int]) -> tuple[Ints, Floats]:
        """Trace the rays of a picture.

        Parameters
        ----------
        sight : Sight
        packets : bool
            Whether 4 x 4 rays are traced at once, as coherent ones; else each on its own.
        face_of : (n + 1,) int32
            Face of each triangle; the last is the background.
        size : (H, W)

        Returns
        -------
        face : (H, W) int32
        depth : (H, W) float64
        """
        side, flags = (PACKET_SIDE, RAY_QUERY_FLAG_COHERENT) if packets else (1, 0)
        # ``RTCIntersectArguments``: flags, features, and pointers to a context and filters: none.
        query = np.array([flags, FEATURE_FLAG_ALL, *[0] * 6], np.int32)
        room = packets_of(side * side)
        mask = room[SHARES].view(np.int32)
        mask[:] = TRACED
        intersect = library().rtcIntersect16 if packets else library().rtcIntersect1
        whereby = (mask.ctypes.data, self.address) if packets else (self.address,)
        answer = np.empty(size, np.int32), np.empty(size)
        trace(intersect, whereby, query.ctypes.data, sight, room, face_of, answer)
        return answer


def _copy(geometry: int, buffer: int, kind: int, rows: Array) -> None:
    """Copy an array (n, 3) of four-byte numbers, C-contiguous, into a new buffer of a geometry."""
    target = library().rtcSetNewGeometryBuffer(geometry, buffer, 0, kind, rows.strides[0], len(rows))
    if target is not None:
        ctypes.memmove(target, rows.ctypes.data, rows.nbytes)


def _check(device: int) -> None:
    """Raise a MethodError if a call has failed."""
    code = library().rtcGetDeviceError(device)
    if code != 0:
        raise MethodError(f"Embree fails ({ERRORS.get(code, code)}); try a smaller scene or another method")
