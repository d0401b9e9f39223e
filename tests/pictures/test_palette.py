from __future__ import annotations

import numpy as np

from hsr.difference.classes import SampleClass
from hsr.models.stages import Cause
from hsr.pictures.palette import CAUSE_COLOURS, CLASS_COLOURS, face_colours


def test_classes_and_causes_have_colours_in_the_order_of_their_numbers() -> None:
    assert list(CLASS_COLOURS) == [kind.label for kind in SampleClass if kind]
    assert list(CAUSE_COLOURS) == [cause.label for cause in Cause if cause]


def test_neighbouring_ids_look_unlike() -> None:
    colours = face_colours(np.arange(1000)).astype(int)
    for apart in (*range(1, 12), 13, 21, 34):
        assert abs(colours[apart:] - colours[:-apart]).max(axis=1).min() >= 14, apart


def test_no_face_looks_like_the_background() -> None:
    neutral, *rest = face_colours(np.arange(-1, 5000)).astype(int)
    assert len(set(neutral)) == 1
    assert (np.ptp(rest, axis=1) > 40).all()
