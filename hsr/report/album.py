"""The pictures of checks: small PNG files, each stored once, shown in layers.

A map and its baseline agree at most samples. So what was judged is the expected picture with a second
one on top that holds only the pixels that differ and is transparent elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hsr.arrays import Array, Pixels
from hsr.difference.classes import Difference, SampleClass
from hsr.report.pictures import CLASS_COLOURS, data_uri, opaque
from hsr.shading import depth_picture, depth_span, face_picture

FAINT = 0.2
"""Opacity of the faces beneath a map of classes."""

BOXES = 12
"""How many clusters are marked in a picture."""

Layers = list[tuple[int, float]]
"""Pictures from the bottom up: place in the album and opacity."""


class Album:
    """PNG pictures as data URIs, equal ones kept once."""

    def __init__(self) -> None:
        self.uris: list[str] = []
        self._place: dict[str, int] = {}

    def add(self, pixels: Pixels) -> int:
        """Keep a picture and return its place.

        Parameters
        ----------
        pixels : (H, W, 4) uint8
            sRGB and opacity, row 0 at the top.
        """
        uri = data_uri(pixels)
        if uri not in self._place:
            self._place[uri] = len(self.uris)
            self.uris.append(uri)
        return self._place[uri]


def gather_pair(key: str, name: str, found: Difference, album: Album) -> dict[str, Any]:
    """Put the pictures of one difference into the album: the reference, then what was judged.

    Parameters
    ----------
    key : str
        By which an address names it.
    name : str
        What to call the judged map.
    found : Difference
    album : Album

    Returns
    -------
    dict
        JSON values for the viewer: ``key``, ``name``, ``width``, ``height``, ``reference`` (place of the
        method the first pane shows) and for every ``methods`` its ``name``, its ``layers`` by kind of
        picture and the ``boxes`` of its largest clusters.
    """
    span, faces = depth_span(found.b), face_picture(found.b)
    face_base = album.add(opaque(faces))
    both_tell = found.a.tells_depth and found.b.tells_depth
    grey, greys = depth_picture(found.a, span), depth_picture(found.b, span)
    expected: dict[str, Layers] = {"faces": [(face_base, 1.0)]}
    shown = {
        "difference": [(face_base, FAINT), (album.add(_classes(found)), 1.0)],
        "faces": _layered(album, face_base, face_picture(found.a), found.a.face != found.b.face),
    }
    if both_tell:
        depth_base = album.add(opaque(greys))
        expected["depth"] = [(depth_base, 1.0)]
        shown["depth"] = _layered(album, depth_base, grey, grey != greys)
    boxes = [list(cluster.box) for cluster in found.clusters[:BOXES]]
    methods: list[dict[str, Any]] = [
        {"name": found.b.method, "layers": expected, "boxes": []},
        {"name": name, "layers": shown, "boxes": boxes},
    ]
    return _scene(key, (found.a.width, found.a.height), methods)


def gather_pictures(key: str, pictures: Mapping[str, Pixels], album: Album) -> dict[str, Any]:
    """Put pictures that are only looked at into the album; for the viewer like :func:`gather_pair`.

    Parameters
    ----------
    key : str
    pictures : mapping of str to (H, W) or (H, W, 3) uint8
        One or more of one size, by name.
    album : Album
    """
    methods = [
        {"name": name, "layers": {"picture": [(album.add(opaque(picture)), 1.0)]}, "boxes": []}
        for name, picture in pictures.items()
    ]
    height, width = next(iter(pictures.values())).shape[:2]
    return _scene(key, (width, height), methods)


def _scene(key: str, size: tuple[int, int], methods: list[dict[str, Any]]) -> dict[str, Any]:
    width, height = size
    return {"key": key, "name": key, "width": width, "height": height, "reference": 0, "methods": methods}


def _layered(album: Album, base: int, picture: Pixels, differs: Array) -> Layers:
    if not differs.any():
        return [(base, 1.0)]
    return [(base, 1.0), (album.add(np.where(differs[..., None], opaque(picture), np.uint8(0))), 1.0)]


def _classes(difference: Difference) -> Pixels:
    """Paint the class of every sample; same is transparent."""
    palette = np.zeros((len(SampleClass), 4), dtype=np.uint8)
    for kind, colour in CLASS_COLOURS.items():
        palette[kind] = (*colour, 255)
    return palette[difference.classes]
