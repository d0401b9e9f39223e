"""The painter's algorithm: what the truth does not explain, the missing depth test does."""

from __future__ import annotations

from hsr.algorithms.painter import Options, render
from hsr.base.arrays import Array, Ints
from hsr.models.rounded import tessellation
from hsr.models.stages import Cause, Pipeline, Stage, rerun
from hsr.problem.view import View

rendered = rerun(render)


def no_depth_test(view: View, options: Options, samples: Array) -> Ints:
    """Run the method: polygons sorted, and painted over each other."""
    return rendered(view, options)[0].ravel()[samples]


PIPELINE = Pipeline(
    (Stage(Cause.TESSELLATION, tessellation), Stage(Cause.NO_DEPTH_TEST, no_depth_test)), rendered
)
