"""What every method promises, tried on small scenes; a method of another package proves itself by it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hsr.algorithms.registry import RESOLVES, Method, method_named
from hsr.base.arrays import Bools
from hsr.base.errors import VisibilityError
from hsr.difference.cause import causes_by
from hsr.difference.classes import depth_step
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene

SIZE, GRID_SIZE = (12, 9), (16, 8)

NEAR_BY, ROUGHLY = 1e-6, 0.02
"""By how much a depth may be off, relative to it, beside two steps of what the map can hold: of a certified
method, and of one whose corners may have been moved by a fraction of a pixel."""


class Trial(NamedTuple):
    """One promise, and a scene in which it would be seen broken.

    Attributes
    ----------
    promise : str
    objects : tuple of dict
    camera : dict
    needs : str
        What a method must resolve by; see :data:`hsr.algorithms.registry.RESOLVES`.
    """

    promise: str
    objects: tuple[dict[str, Any], ...]
    camera: dict[str, Any]
    needs: str = "nothing"

    @property
    def close(self) -> bool:
        """Whether samples lie on edges, on near or far, or where depths are equal.

        There a method that is not certified may err, as far as its own models say why.
        """
        return self.camera == GRID

    def view(self) -> View:
        """Return what is seen."""
        scene = {"hsr": 1, "camera": [self.camera], "object": list(self.objects)}
        return view(Scene.model_validate(scene), GRID_SIZE if self.close else SIZE)


def _thing(name: str, shape: str, *transform: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {"name": name, "shape": shape, "transform": list(transform), **keys}


def _tile(name: str, *corners: tuple[float, float], z: float = 0.0) -> dict[str, Any]:
    """Make a triangle that faces the parallel camera."""
    vertices = [[x, y, z] for x, y in corners]
    return {"name": name, "shape": "mesh", "vertices": vertices, "faces": [[0, 1, 2]]}


def _eye(x: float, y: float, **keys: Any) -> dict[str, Any]:
    """Make a camera; where it stands, no sample is within a twentieth of a pixel of an edge."""
    return {"type": "perspective", "eye": [x, y, 5.0], "near": 1.0, "far": 20.0, **keys}


PARALLEL = {"type": "orthographic", "eye": [2.33, 0.98, 5.0], "height": 4.1, "near": 1.0, "far": 20.0}
GRID = {"type": "orthographic", "eye": [0.0, 0.0, 5.0], "height": 8.0, "near": 1.0, "far": 9.0}
"""A camera whose samples lie at x + 1/2 and y + 1/2, x and y whole numbers, without any rounding."""

BOX = _thing("box", "cube")
MIRRORED = _thing("box", "cube", {"scale": [-1, 1, 1]}, cull="back")
BALL = _thing("ball", "sphere")

BEHIND = _thing("behind", "cube", {"translate": [0.45, 0.3, -3.0]})
BEFORE = _thing("before", "cube", {"scale": 0.5}, {"translate": [-0.35, 0.15, 1.0]})

INSIDE = _thing("inside", "cube", cull="front")
TURNED = _thing("back", "square", {"rotate_y": 180.0}, {"translate": [0, 0, 2]}, cull="back")
WALL = _thing("wall", "square", {"scale": 3}, {"translate": [0, 0, -3]}, cull="none")

ONE = _thing("one", "square", {"scale": 1.4}, {"rotate_y": 40.0})
OTHER = _thing("other", "square", {"scale": 1.3}, {"rotate_y": -50.0})

LEFT = _tile("left", (-5.5, -3.5), (1.5, 3.5), (-5.5, 3.5))
RIGHT = _tile("right", (-5.5, -3.5), (1.5, -3.5), (1.5, 3.5))
FIRST, SECOND, NEAR, FAR = (
    _tile(name, (-20.0, -20.0), (20.0, -20.0), (0.0, 30.0), z=z)
    for name, z in (("first", 0.0), ("second", 0.0), ("wall", 4.0), ("wall", -4.0))
)

TRIALS = (
    Trial("a convex solid hides its own back", (BOX,), _eye(-2.16, 1.92)),
    Trial("a parallel camera sees as far as it says", (BOX,), PARALLEL),
    Trial("nothing is seen of what is behind the eye", (BOX,), _eye(0.63, 0.97, target=[0.0, 0.0, 9.0])),
    Trial("a mirrored object keeps its outside", (MIRRORED,), _eye(2.13, -1.65)),
    Trial("a curved shape is seen", (BALL,), _eye(0.63, 0.97)),
    Trial("the nearer of two objects hides the other", (BEHIND, BEFORE), _eye(1.52, 1.37), "order"),
    Trial("what is culled is not there", (INSIDE, TURNED, WALL), _eye(-0.05, 0.22), "depth"),
    Trial(
        "objects that cut through each other are told apart at every sample",
        (ONE, OTHER),
        _eye(-0.82, -2.64),
        "depth",
    ),
    Trial("a shared edge has one owner, top or left", (LEFT, RIGHT), GRID),
    Trial("of equal depths the lowest face is shown", (FIRST, SECOND), GRID, "depth"),
    Trial("what lies at near is seen", (NEAR,), GRID),
    Trial("what lies at far is seen", (FAR,), GRID),
)


def check_method(method: Method | str) -> None:
    """Have a method prove what its row promises, on small scenes.

    Every answer must be well formed, and the same when asked again. A certified method shows the true face
    at every sample. Another must be right where no sample is near an edge and no depths are close, in scenes
    that it resolves; what it shows wrong elsewhere must be explained by its own models, if it has any.

    Parameters
    ----------
    method : Method or str
        A row, registered or not, or the name of a registered one.

    Raises
    ------
    VisibilityError
        At the first promise that is broken; an ``AssertionError`` that names promise, sample and faces.
    UnavailableError
        If the method needs what this machine lacks.

    Examples
    --------
    >>> import hsr
    >>> from hsr.testing import check_method
    >>> check_method("painter")
    """
    row = method_named(method) if isinstance(method, str) else method
    for trial in TRIALS:
        seen = trial.view() if row.curved else trial.view().tessellated()
        for why in _broken(row, trial, seen):
            promise = f"{trial.promise} ({seen.width}x{seen.height})"
            raise VisibilityError(f"{row.name} does not keep that {promise}: {why}")


def _broken(row: Method, trial: Trial, seen: View) -> Iterator[str]:
    """Yield by what a promise is broken; what comes later is to be asked only if nothing came before."""
    answer, again, truth = row.render(seen), row.render(seen), method_named("exact").render(seen)
    yield from _malformed(seen, answer)
    same = (answer.face == again.face) & ((answer.depth == again.depth) | np.isnan(answer.depth))
    yield from _samples(same, "another answer when asked again")
    if row.certified:
        yield from _wrong(answer, truth, answer.face == truth.face)
    elif not trial.close and RESOLVES.index(row.resolves) <= RESOLVES.index(trial.needs):
        yield from _wrong(answer, truth, truth.admits(answer.face))
    elif row.pipeline:
        found = causes_by(row, seen, answer, truth)
        if found.unexplained or found.reproduced is False:
            yield f"its models do not show what it shows; causes: {found.counts}"
    if answer.tells_depth and not trial.close:
        yield from _samples(_deep_enough(row, answer, truth), "another depth than that of the face it shows")


def _malformed(seen: View, answer: VisibilityMap) -> Iterator[str]:
    """Yield what is not as in every map."""
    face, depth = answer.face, answer.depth
    told = (face.shape, str(face.dtype), str(depth.dtype))
    if told != ((seen.height, seen.width), "int32", "float64"):
        yield f"faces {face.shape} {face.dtype} and depths {depth.dtype} are not int32 and float64"
    yield from _samples((face >= BACKGROUND) & (face < seen.faces), "a face that there is not")
    if answer.tells_depth:
        yield from _samples((face == BACKGROUND) == np.isposinf(depth), "a background that is not at +inf")
    if "render" not in answer.seconds or not all(isinstance(n, int) for n in answer.work.values()):
        yield "seconds need 'render', and work whole numbers"


def _deep_enough(row: Method, answer: VisibilityMap, truth: VisibilityMap) -> Bools:
    """Tell where the depth (H, W) is that of the truth, or another face is shown."""
    fine: Bools = (answer.face != truth.face) | (truth.face == BACKGROUND)
    depth, near_by = truth.depth[~fine], NEAR_BY if row.certified else ROUGHLY
    reach = near_by * np.abs(depth) + 2.0 * depth_step(answer, depth)
    fine[~fine] = np.abs(answer.depth[~fine] - depth) <= reach
    return fine


def _wrong(answer: VisibilityMap, truth: VisibilityMap, fine: Bools) -> Iterator[str]:
    for y, x in np.argwhere(~fine):
        shown, true = (map.name_of(int(map.face[y, x])) for map in (answer, truth))
        yield f"sample {x},{y} shows {shown}, the truth is {true}"


def _samples(fine: Bools, what: str) -> Iterator[str]:
    """Yield for each sample that is not fine what it shows."""
    return (f"sample {x},{y} shows {what}" for y, x in np.argwhere(~fine))
