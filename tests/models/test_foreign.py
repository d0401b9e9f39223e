"""Models of renderers from outside: their names, their parameters, and what a map notes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import HsrError
from hsr.models.foreign import CANDIDATES, model_of, modelled, models, told_of
from hsr.testing import from_ids

IDS = from_ids(np.array([[0, 1]]))


def test_every_model_names_causes_and_every_candidate_is_one() -> None:
    assert all(row.load_pipeline() for row in models().values())
    assert [told_of(modelled(IDS, **one)) for one in CANDIDATES][-1] == "float32, depth_format d16"


def test_a_map_keeps_its_model(tmp_path: Path) -> None:
    modelled(IDS, "float32", subpixel_bits=4, fill_rule=None).save(tmp_path / "mine.npz")
    method, options = model_of(hsr.load_map(tmp_path / "mine.npz"))
    assert method and method.options(**options).arithmetic == "float32" and options == {"subpixel_bits": 4}


def test_without_a_model_its_method_says_what_made_it() -> None:
    assert model_of(IDS) == (None, {})
    assert (
        model_of(hsr.render(hsr.load("scenes/cube.toml"), "painter", (8, 8)))[0] is hsr.methods()["painter"]
    )


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"model": "float23"}, "there is no model 'float23'; did you mean 'float32'?"),
        (
            {"model": "float32", "subpixel_bits": 5},
            "scanline has no subpixel_bits 5; choose from none, 4, 8, 12",
        ),
        ({"model": "embree", "fill_rule": "top-left"}, "embree has no option 'fill_rule'"),
    ],
)
def test_what_makes_no_sense_is_told(given: dict[str, Any], complaint: str) -> None:
    with pytest.raises(HsrError) as error:
        modelled(IDS, **given)
    assert complaint in str(error.value) and "\n" not in str(error.value)
