"""OpenGL, stage by stage, as far as the driver is the one that is modelled.

The tessellation is judged exactly, the stages of the driver by :mod:`hsr.difference.models.llvmpipe`,
whose last model is not the driver run again but a prediction of what it draws.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from hsr.algorithms.opengl import Options
from hsr.arrays import Array, Floats, Ints
from hsr.difference.models import llvmpipe
from hsr.difference.models.rounded import tessellation
from hsr.difference.models.stages import Cause, Pipeline, Stage
from hsr.opengl.drawing import depth_of_window
from hsr.viewing import View
from hsr.visibility import BACKGROUND


@lru_cache(maxsize=1)
def predicted(view: View, options: Options) -> tuple[Ints, Floats]:
    """Predict faces and depths (H, W) of the driver."""
    prediction = llvmpipe.predict(view, driver=llvmpipe.Driver(depth=options.buffer))
    depth = np.full(prediction.face.shape, np.inf)
    drawn = prediction.face != BACKGROUND
    depth[drawn] = depth_of_window(view, prediction.window[drawn], options.buffer.reversed)
    return prediction.face, depth


def _up_to(stage: llvmpipe.Stage) -> Callable[[View, Options, Array], Ints]:
    def faces(view: View, options: Options, samples: Array) -> Ints:
        if stage == llvmpipe.Stage.DEPTH_FORMAT:
            face, _ = predicted(view, options)
        else:
            face = llvmpipe.predict(view, stage, llvmpipe.Driver(depth=options.buffer)).face
        return np.asarray(face.ravel()[samples])

    return faces


PIPELINE = Pipeline(
    (
        Stage(Cause.TESSELLATION, tessellation),
        *(Stage(Cause[stage.name], _up_to(stage)) for stage in llvmpipe.Stage),
    ),
    predicted,
)
