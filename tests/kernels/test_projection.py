"""Clip space, the screen and window depth."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.kernels.projection import clip_rows, to_clip, to_depth, to_screen


def test_rows_of_a_placed_camera_are_kept_bit_for_bit() -> None:
    clip_from_world = np.array([[1.7, 0.1, 0, 3], [0, 2.3, 0.2, 1], [9, 9, 9, 9], [0.1, 0.2, -0.9, 5]])
    rows = clip_rows(clip_from_world, clip_from_world[3])
    assert np.array_equal(rows, clip_from_world[[0, 1, 3]])


@pytest.mark.parametrize("scale", [0.5, 4.0])
def test_rows_are_in_units_of_depth(scale: float) -> None:
    depth_row = np.array([0.0, 0.0, -1.0, 2.0])
    clip_from_world = np.stack([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], scale * depth_row])
    rows = clip_rows(clip_from_world, depth_row)
    assert np.array_equal(rows, [[1 / scale, 0, 0, 0], [0, 1 / scale, 0, 0], depth_row])


def test_rows_of_a_parallel_camera_are_in_units_of_w() -> None:
    depth_row = np.array([0.0, 0.0, -1.0, 2.0])
    clip_from_world = np.stack([[3, 0, 0, 0], [0, 6, 0, 0], [0, 0, -1, 0], [0, 0, 0, 3.0]])
    assert np.array_equal(clip_rows(clip_from_world, depth_row), [[1, 0, 0, 0], [0, 2, 0, 0], depth_row])


def test_world_to_clip() -> None:
    rows = np.array([[1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, -1.0, 5.0]])
    assert np.array_equal(to_clip(np.array([[1.0, 10.0, 100.0]]), rows), [[325.0, 9.0, -95.0]])


def test_corners_of_the_view_are_the_corners_of_the_image() -> None:
    clip = np.array([[-2.0, 2.0, 2.0], [4.0, -4.0, 4.0], [0.0, 0.0, 8.0]])
    screen = to_screen(clip, True, (6, 4), (2.0, 8.0))
    # (1 - 2/4) / (1 - 2/8) = 2/3
    assert screen == pytest.approx(np.array([[0, 0, 0], [6, 4, 2 / 3], [3, 2, 1]]), abs=1e-15)


def test_parallel_view_does_not_divide() -> None:
    clip = np.array([[-1.0, 1.0, 2.0], [1.0, -1.0, 5.0], [0.0, 0.0, 8.0]])
    screen = to_screen(clip, False, (6, 4), (2.0, 8.0))
    assert np.array_equal(screen, [[0, 0, 0], [6, 4, 0.5], [3, 2, 1]])


def test_window_depth_is_affine_on_the_screen() -> None:
    ends = np.array([[-1.0, 0.0, 1.0], [3.0, 0.0, 4.0]])
    middle = 0.3 * ends[0] + 0.7 * ends[1]
    (x0, _, z0), (x1, _, z1), (x, _, z) = to_screen(np.stack([*ends, middle]), True, (10, 10), (0.5, 9.0))
    assert z == pytest.approx(z0 + (x - x0) / (x1 - x0) * (z1 - z0), rel=1e-14)


@pytest.mark.parametrize(("perspective", "far"), [(True, 50.0), (True, np.inf), (False, 50.0)])
def test_depth_comes_back(perspective: bool, far: float) -> None:
    depth = np.linspace(0.5, 50.0, 40)
    clip = np.stack([0 * depth, 0 * depth, depth], axis=1)
    window = to_screen(clip, perspective, (8, 8), (0.5, far))[:, 2].reshape(4, 10)
    assert to_depth(window, perspective, (0.5, far)).ravel() == pytest.approx(depth, rel=1e-13)


@pytest.mark.parametrize("perspective", [True, False])
def test_background_stays_infinite_and_depths_stay_in_range(perspective: bool) -> None:
    window = np.array([[np.inf, -0.1, 0.0, 1.0, 1.1]])
    assert to_depth(window, perspective, (2.0, 8.0)) == pytest.approx(np.array([[np.inf, 2, 2, 8, 8]]))


@pytest.mark.parametrize(("real", "last"), [(np.float64, 2.0**53), (np.float32, 2.0**24)])
def test_depth_without_a_far_plane_is_finite(real: type, last: float) -> None:
    window = np.array([[1.0, np.inf]], real)
    assert to_depth(window, True, (1.0, np.inf)).tolist() == [[last, np.inf]]
