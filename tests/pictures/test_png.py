from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hsr.base.errors import HsrError
from hsr.pictures.png import data_uri, save_picture


def decoded(uri: str) -> Any:
    with Image.open(io.BytesIO(base64.b64decode(uri.removeprefix("data:image/webp;base64,")))) as image:
        return np.asarray(image.convert("RGBA"))


@pytest.mark.parametrize("colours", [1, 2, 256, 257])
def test_a_page_s_picture_keeps_every_pixel(colours: int) -> None:
    value = np.arange(32 * 32) % colours
    opacity = np.where(value % 3 == 0, 0, 255)
    pixels = np.stack([value % 256, value // 256, 255 - value % 256, opacity], axis=1)
    pixels = pixels.reshape(32, 32, 4).astype(np.uint8)
    assert np.array_equal(decoded(data_uri(pixels)), pixels)


@pytest.mark.parametrize("shape", [(1, 2), (1, 2, 3)])
def test_a_picture_without_opacity_is_opaque(shape: tuple[int, ...]) -> None:
    assert decoded(data_uri(np.full(shape, 7, np.uint8))).tolist() == [[[7, 7, 7, 255]] * 2]


def test_save_picture(tmp_path: Path) -> None:
    picture = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    save_picture(picture, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert np.array_equal(np.asarray(image), picture)
    with pytest.raises(HsrError, match=r"none/a\.png: cannot write the picture"):
        save_picture(picture, tmp_path / "none/a.png")
