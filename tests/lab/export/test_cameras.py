"""Cameras in the conventions of other programs, each followed by hand."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import ViewError
from hsr.lab.export.cameras import conventions
from hsr.scene.model import Camera

TURNED = hsr.Perspective(eye=(3, 2, 4), target=(0.5, 0, 0), up=(0.2, 1, 0), fov=35.0, near=0.5, far=20.0)


def beside() -> hsr.MatrixCamera:
    """A camera whose axis is not in the middle of its picture, and whose w is no depth in units of length."""
    clip = hsr.view(hsr.load("cube"), (90, 60), TURNED).clip_from_world
    shift = np.array(
        [[1.0, 0.0, 0.0, 0.3], [0.0, 1.0, 0.0, -0.1], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )
    return hsr.MatrixCamera(matrix=(2.5 * shift @ clip).tolist())


CAMERAS = {
    "perspective": TURNED,
    "infinite": hsr.Perspective(eye=(-1, 3, 5)),
    "parallel": hsr.Orthographic(eye=(3, 2, 4), target=(0.5, 0, 0), height=4.0, near=0.5, far=20.0),
    "beside": beside(),
    "parallel matrix": hsr.MatrixCamera(
        matrix=[[0.5, 0, 0, 0.25], [0, 0.7, 0, 0.1], [0, 0, -0.2, 0], [0, 0, 0, 1]]
    ),
}


def seen(camera: Camera, size: tuple[int, int] = (90, 60)) -> tuple[hsr.View, dict[str, Any]]:
    """A view, and what is told of it, as it is read from the file."""
    view = hsr.view(hsr.load("cube"), size, camera)
    return view, json.loads(json.dumps(conventions(view)))


def from_ndc(ndc: Any, told: dict[str, Any]) -> Any:
    """From OpenGL's coordinates on the screen to columns and rows, whole numbers at centres of pixels."""
    width, height = told["size"]
    return (ndc[:, 0] + 1) * width / 2 - 0.5, (1 - ndc[:, 1]) * height / 2 - 0.5


def opengl(points: Any, told: dict[str, Any], matrices: tuple[str, ...]) -> Any:
    clip = np.column_stack([points, np.ones(len(points))])
    for name in matrices:
        clip = clip @ np.array(told["opengl"].get(name, told["nvdiffrast"]["clip_from_world"])).T
    return from_ndc(clip / clip[:, 3:], told)


def opencv(points: Any, told: dict[str, Any]) -> Any:
    own = points @ np.array(told["opencv"]["camera_from_world"])[:3, :3].T
    own = own + np.array(told["opencv"]["camera_from_world"])[:3, 3]
    flat = own / own[:, 2:] if told["perspective"] else np.column_stack([own[:, :2], np.ones(len(own))])
    return tuple((flat @ np.array(told["opencv"]["K"]).T)[:, :2].T)


def pytorch3d(points: Any, told: dict[str, Any]) -> Any:
    camera = told["pytorch3d"]
    assert camera["camera"] == ("PerspectiveCameras" if told["perspective"] else "OrthographicCameras")
    own = points @ np.array(camera["R"]) + camera["T"]
    flat = own[:, :2] / own[:, 2:] if told["perspective"] else own[:, :2]
    x, y = (flat * camera["focal_length"] + camera["principal_point"]).T
    height, width = camera["image_size"]
    side = min(height, width)
    return (width - x * side - 1) / 2, (height - y * side - 1) / 2


@pytest.mark.parametrize("size", [(90, 60), (60, 90)])
@pytest.mark.parametrize("name", CAMERAS)
def test_every_convention_sees_a_point_in_the_same_pixel(name: str, size: tuple[int, int]) -> None:
    view, told = seen(CAMERAS[name], size)
    points = np.random.default_rng(20).uniform(-1.0, 1.0, (50, 3))
    clip = np.column_stack([points, np.ones(50)]) @ view.clip_from_world.T
    expected = from_ndc(clip / clip[:, 3:], told)
    ways = {
        "clip": opengl(points, told, ("clip_from_world",)),
        "factors": opengl(points, told, ("camera_from_world", "clip_from_camera")),
        "nvdiffrast": opengl(points, told, ("none of its own",)),
        "opencv": opencv(points, told),
        "pytorch3d": pytorch3d(points, told),
    }
    for way, found in ways.items():
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=way)


@pytest.mark.parametrize("name", CAMERAS)
def test_frames_turn_and_do_not_mirror(name: str) -> None:
    view, told = seen(CAMERAS[name])
    frames = [np.array(told[one]["camera_from_world"])[:3, :3] for one in ("opengl", "opencv")]
    for turned in (*frames, np.array(told["pytorch3d"]["R"])):
        np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turned) == pytest.approx(1.0)
    # OpenGL looks along -z, the others along z: that is the depth.
    depth = view.depth_row[:3]
    np.testing.assert_allclose(
        [-frames[0][2], frames[1][2], np.array(told["pytorch3d"]["R"])[:, 2]], [depth] * 3
    )


def test_planes_and_the_exact_matrix() -> None:
    view, told = seen(TURNED)
    assert (told["near"], told["far"], told["size"]) == (0.5, 20.0, [90, 60])
    assert told["opengl"]["clip_from_world"] == view.clip_from_world.tolist()
    assert seen(CAMERAS["infinite"])[1]["far"] is None
    # z / w of OpenGL's own factors is -1 at near and 1 at far.
    clip_from_camera = np.array(told["opengl"]["clip_from_camera"])
    for depth, z in ((0.5, -1.0), (20.0, 1.0)):
        clip = clip_from_camera @ [0.1, 0.2, -depth, 1.0]
        assert clip[2] / clip[3] == pytest.approx(z)


@pytest.mark.parametrize(
    "change",
    [np.diag([-1.0, 1.0, 1.0, 1.0]), np.array([[1, 0.1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])],
    ids=["mirrors", "shears"],
)
@pytest.mark.parametrize("name", ["perspective", "parallel"])
def test_cameras_that_mirror_or_shear_are_refused(name: str, change: Any) -> None:
    clip = hsr.view(hsr.load("cube"), (90, 60), CAMERAS[name]).clip_from_world
    camera = hsr.MatrixCamera(matrix=(change @ clip).tolist())
    with pytest.raises(ViewError, match=r"^the camera mirrors or shears .* --eye 2,2,4$"):
        seen(camera)


def test_slanted_parallel_lines_of_sight_are_refused() -> None:
    slanted = [[0.5, 0, 0.1, 0], [0, 0.5, 0, 0], [0, 0, -0.2, 0], [0, 0, 0, 1]]
    with pytest.raises(ViewError, match="mirrors or shears"):
        seen(hsr.MatrixCamera(matrix=slanted))
