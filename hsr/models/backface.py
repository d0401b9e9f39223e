"""Back-face detection alone: what the truth does not explain, the missing depth test does."""

from hsr.algorithms.backface import render
from hsr.models.rounded import TESSELLATED
from hsr.models.stages import Cause, ending, rerun

PIPELINE = ending(rerun(render), Cause.NO_DEPTH_TEST, TESSELLATED)
