"""Back-face detection alone: what the truth does not explain, the missing depth test does."""

from __future__ import annotations

from functools import lru_cache

from hsr.algorithms.backface import Options, render
from hsr.arrays import Array, Floats, Ints
from hsr.difference.models.rounded import tessellation
from hsr.difference.models.stages import Cause, Pipeline, Stage
from hsr.viewing import View


@lru_cache(maxsize=1)
def rendered(view: View, options: Options) -> tuple[Ints, Floats]:
    """Run the method again: its faces and depths (H, W)."""
    again = render(view, options)
    return again.face, again.depth


def no_depth_test(view: View, options: Options, samples: Array) -> Ints:
    """Run the method: back faces removed, the others painted over each other."""
    return rendered(view, options)[0].ravel()[samples]


PIPELINE = Pipeline(
    (Stage(Cause.TESSELLATION, tessellation), Stage(Cause.NO_DEPTH_TEST, no_depth_test)), rendered
)
