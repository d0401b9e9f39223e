from __future__ import annotations

import numpy as np

from hsr.difference.classes import SampleClass, compare
from hsr.difference.study import Study
from hsr.pictures.maps import SMALL, class_picture, depth_picture, depth_shares, depth_span, face_picture
from hsr.pictures.palette import CLASS_COLOURS, COVERED, face_colours
from hsr.problem.map import VisibilityMap


def test_face_picture_paints_by_id_alone() -> None:
    face = np.array([[-1, 3], [3, 70_000]], np.int32)
    picture = face_picture(face)
    assert picture.shape == (2, 2, 3) and picture.dtype == np.uint8
    assert np.array_equal(picture.reshape(4, 3), face_colours(face.ravel()))
    assert (picture[0, 1] == picture[1, 0]).all() and (picture[0, 1] != picture[1, 1]).any()


def test_depth_picture_is_light_near_and_black_where_nothing_is() -> None:
    near, middle, far, nothing = depth_picture(np.array([[1.0, 2.0, 3.0, np.inf]]))[0]
    assert near > middle > far > nothing == 0


def test_shares_of_one_span_agree() -> None:
    first, second = np.array([[1.0, 5.0]]), np.array([[2.0, 5.0]])
    span = depth_span(first)
    assert span == (1.0, 5.0)
    assert depth_shares(first, span).tolist() == [[0.0, 1.0]]
    assert depth_shares(second, span).tolist() == [[0.25, 1.0]]


def test_depth_picture_of_flat_and_empty_maps() -> None:
    assert depth_picture(np.array([[2.0, 2.0]])).tolist() == [[242, 242]]
    assert depth_picture(np.array([[np.inf]])).tolist() == [[0]]


def test_a_small_picture_shows_what_counts_and_what_is_covered(studied: Study) -> None:
    difference = studied.differences["shifted"]
    picture = difference.picture()
    for kind in (SampleClass.MISSING, SampleClass.EXTRA, SampleClass.WRONG_FACE):
        here = difference.classes == kind
        assert here.any() and (picture[here] == (*CLASS_COLOURS[kind.label], 255)).all()
    assert tuple(picture[30, 30]) == COVERED and tuple(picture[0, 0]) == (0, 0, 0, 0)


def test_a_small_picture_of_no_class_shows_what_is_covered() -> None:
    picture = class_picture(np.full((2, 2), 3, np.uint8), np.array([[True, False], [False, True]]), {})
    assert [tuple(pixel) for pixel in picture.reshape(4, 4)] == [COVERED, 4 * (0,), 4 * (0,), COVERED]


def test_a_single_sample_survives_in_a_small_picture() -> None:
    face = np.full((700, 500), -1, np.int32)
    face[333, 444] = 0
    depth = np.full(face.shape, np.inf)
    nothing = VisibilityMap(np.full_like(face, -1), depth, "b")
    picture = compare(VisibilityMap(face, depth, "a"), nothing).picture()
    assert max(picture.shape) <= SMALL
    assert picture[333 // 4, 444 // 4].tolist() == [*CLASS_COLOURS["extra"], 255]
    assert np.count_nonzero(picture[..., 3]) == 1
