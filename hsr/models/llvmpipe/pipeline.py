"""OpenGL, stage by stage, as far as the driver is the one that is modelled.

The tessellation is judged exactly, the stages of the driver by :mod:`hsr.models.llvmpipe.driver`,
whose last model is not the driver run again but a prediction of what it draws.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from hsr.algorithms.opengl import Options
from hsr.base.arrays import Array, Floats, Ints
from hsr.gl.drawing import depth_of_window
from hsr.models.llvmpipe import driver
from hsr.models.rounded import TESSELLATED
from hsr.models.stages import Cause, Stage, ending
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View


@lru_cache(maxsize=1)
def predicted(view: View, options: Options) -> tuple[Ints, Floats]:
    """Predict faces and depths (H, W) of the driver."""
    face, window = driver.predict(view, buffer=options.buffer)
    depth, drawn = np.full(face.shape, np.inf), face != BACKGROUND
    depth[drawn] = depth_of_window(view, window[drawn], options.buffer.reversed)
    return face, depth


def _up_to(stage: Cause) -> Stage:
    def faces(view: View, options: Options, samples: Array) -> Ints:
        return driver.predict(view, stage, options.buffer, samples).face.ravel()[samples]

    return Stage(stage, faces)


PIPELINE = ending(predicted, Cause.DEPTH_FORMAT, TESSELLATED, *map(_up_to, driver.STAGES[:-1]))
