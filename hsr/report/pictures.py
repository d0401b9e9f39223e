"""The pictures of a report: small PNG files, each stored once, shown in layers.

Most methods agree at most samples. So a method's picture is the reference's picture with a second
one on top that holds only the pixels that differ and is transparent elsewhere.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from PIL import Image

from hsr.arrays import Array, Pixels
from hsr.difference.classes import Difference, SampleClass
from hsr.difference.study import Study
from hsr.shading import depth_picture, depth_span, face_picture, shade
from hsr.visibility import VisibilityMap

CLASS_COLOURS = {
    SampleClass.MISSING: (0, 114, 178),
    SampleClass.EXTRA: (230, 159, 0),
    SampleClass.WRONG_FACE: (204, 32, 38),
    SampleClass.DEPTH_ONLY: (150, 176, 168),
    SampleClass.TIE: (204, 121, 167),
}
"""sRGB of the classes, told apart by people who see no red or no green as well."""

FAINT = 0.2
"""Opacity of the shaded picture beneath a map of classes."""

BOXES = 12
"""How many clusters are marked in a picture."""

Layers = list[tuple[int, float]]
"""Pictures from the bottom up: place in the album and opacity."""


class Album:
    """PNG pictures as data URIs, equal ones kept once."""

    def __init__(self) -> None:
        self.uris: list[str] = []
        self._place: dict[bytes, int] = {}

    def add(self, pixels: Pixels) -> int:
        """Keep a picture and return its place.

        Parameters
        ----------
        pixels : (H, W, 4) uint8
            sRGB and opacity, row 0 at the top.
        """
        data = png(pixels)
        if data not in self._place:
            self._place[data] = len(self.uris)
            self.uris.append(f"data:image/png;base64,{base64.b64encode(data).decode('ascii')}")
        return self._place[data]


def png(pixels: Pixels) -> bytes:
    """Encode a picture as PNG, with a palette where 256 colours suffice.

    Parameters
    ----------
    pixels : (H, W, 4) uint8
        sRGB and opacity, row 0 at the top.
    """
    height, width = pixels.shape[:2]
    colours, index = np.unique(np.ascontiguousarray(pixels).view(np.uint32), return_inverse=True)
    if len(colours) <= 256:
        image = Image.frombytes("P", (width, height), index.astype(np.uint8).tobytes())
        image.putpalette(colours.view(np.uint8).tobytes(), "RGBA")
    else:
        image = Image.fromarray(pixels)
    file = io.BytesIO()
    image.save(file, format="PNG", optimize=True)
    return file.getvalue()


def gather(study: Study, album: Album) -> dict[str, Any]:
    """Put the pictures of a study into the album and say, for the viewer, which are shown where.

    Parameters
    ----------
    study : Study
        With one map at least.
    album : Album

    Returns
    -------
    dict
        JSON values: ``name``, ``width``, ``height``, ``reference`` (place of the method the first
        pane shows) and for every ``methods`` its ``name``, its ``layers`` by kind of picture and the
        ``boxes`` of its largest clusters.
    """
    names = list(study.maps)
    first = study.reference or names[0]
    base = study.maps[first]
    picture = album.add(_opaque(shade(base, study.view)))
    faces, greys, span = face_picture(base), depth_picture(base), depth_span(base)
    face_base, depth_base = album.add(_opaque(faces)), album.add(_opaque(greys))

    def method(name: str, map: VisibilityMap) -> dict[str, Any]:
        grey = depth_picture(map, span)
        layers = {
            "picture": [(picture, 1.0)],
            "faces": _layered(album, face_base, face_picture(map), map.face != base.face),
            "depth": _layered(album, depth_base, grey, grey != greys),
        }
        difference = study.differences.get(name)
        if difference is None:
            return {"name": name, "layers": layers, "boxes": []}
        layers["difference"] = [(picture, FAINT), (album.add(_class_picture(difference)), 1.0)]
        boxes = [list(cluster.box) for cluster in difference.clusters[:BOXES]]
        return {"name": name, "layers": layers, "boxes": boxes}

    return {
        "name": study.scene.title or study.name,
        "width": study.view.width,
        "height": study.view.height,
        "reference": names.index(first),
        "methods": [method(name, map) for name, map in study.maps.items()],
    }


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
        JSON values for the viewer, as :func:`gather` returns them, and ``key``.
    """
    span, faces = depth_span(found.b), face_picture(found.b)
    face_base = album.add(_opaque(faces))
    both_tell = found.a.tells_depth and found.b.tells_depth
    grey, greys = depth_picture(found.a, span), depth_picture(found.b, span)
    expected: dict[str, Layers] = {"faces": [(face_base, 1.0)]}
    shown = {
        "difference": [(face_base, FAINT), (album.add(_class_picture(found)), 1.0)],
        "faces": _layered(album, face_base, face_picture(found.a), found.a.face != found.b.face),
    }
    if both_tell:
        depth_base = album.add(_opaque(greys))
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
        {"name": name, "layers": {"picture": [(album.add(_opaque(picture)), 1.0)]}, "boxes": []}
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
    return [(base, 1.0), (album.add(np.where(differs[..., None], _opaque(picture), np.uint8(0))), 1.0)]


def _opaque(picture: Pixels) -> Pixels:
    """Turn a grey (H, W) or coloured (H, W, 3) picture into (H, W, 4), opaque."""
    height, width = picture.shape[:2]
    opaque = np.full((height, width, 4), 255, dtype=np.uint8)
    opaque[..., :3] = picture.reshape(height, width, -1)
    return opaque


def _class_picture(difference: Difference) -> Pixels:
    """Paint the class of every sample; same is transparent."""
    palette = np.zeros((len(SampleClass), 4), dtype=np.uint8)
    for kind, colour in CLASS_COLOURS.items():
        palette[kind] = (*colour, 255)
    return palette[difference.classes]
