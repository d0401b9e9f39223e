from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hsr.difference.classes import SampleClass, compare
from hsr.difference.study import Study
from hsr.pages.pictures import CLASS_COLOURS, COVERED, SMALL, class_picture, data_uri, opaque, png
from hsr.problem.map import VisibilityMap


def decoded(uri: str) -> Any:
    with Image.open(io.BytesIO(base64.b64decode(uri.removeprefix("data:image/png;base64,")))) as image:
        return np.asarray(image.convert("RGBA"))


@pytest.mark.parametrize("colours", [1, 2, 256, 257])
def test_png_keeps_every_pixel(colours: int) -> None:
    value = np.arange(32 * 32) % colours
    opacity = np.where(value % 3 == 0, 0, 255)
    pixels = np.stack([value % 256, value // 256, 255 - value % 256, opacity], axis=1)
    pixels = pixels.reshape(32, 32, 4).astype(np.uint8)
    with Image.open(io.BytesIO(png(pixels))) as image:
        assert (image.mode == "P") == (colours <= 256)
    assert np.array_equal(decoded(data_uri(pixels)), pixels)


def test_opaque() -> None:
    assert opaque(np.full((1, 2, 3), 7, np.uint8)).tolist() == [[[7, 7, 7, 255]] * 2]


def test_a_small_picture_shows_what_counts_and_what_is_covered(studied: Study) -> None:
    difference = studied.differences["shifted"]
    picture = class_picture(difference)
    for kind in (SampleClass.MISSING, SampleClass.EXTRA, SampleClass.WRONG_FACE):
        here = difference.classes == kind
        assert here.any() and (picture[here] == (*CLASS_COLOURS[kind], 255)).all()
    assert tuple(picture[30, 30]) == COVERED and tuple(picture[0, 0]) == (0, 0, 0, 0)


def test_a_single_sample_survives_in_a_small_picture() -> None:
    face = np.full((700, 500), -1, np.int32)
    face[333, 444] = 0
    depth = np.full(face.shape, np.inf)
    picture = class_picture(compare(VisibilityMap(face, depth, "a"), VisibilityMap(face * 0 - 1, depth, "b")))
    assert max(picture.shape) <= SMALL
    assert picture[333 // 4, 444 // 4].tolist() == [*CLASS_COLOURS[SampleClass.EXTRA], 255]
    assert np.count_nonzero(picture[..., 3]) == 1
