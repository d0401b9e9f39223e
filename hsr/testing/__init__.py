"""Checks of visibility for other people's test suites: by face id, exact where the truth is known.

The pytest plug-in makes the same checks by its fixture ``visibility``; here they are plain functions
that raise :class:`hsr.base.errors.VisibilityError`, an ``AssertionError``, with the same text.
"""

from __future__ import annotations

from hsr.base.errors import VisibilityError
from hsr.models.foreign import modelled
from hsr.testing.checks import assert_agree, assert_matches_baseline, assert_same_visibility, assert_similar
from hsr.testing.conformance import check_method
from hsr.testing.converters import by_object, from_ids, from_nvdiffrast, from_open3d, from_png, from_pyrender
from hsr.testing.images import read_map

__all__ = [
    "VisibilityError",
    "assert_agree",
    "assert_matches_baseline",
    "assert_same_visibility",
    "assert_similar",
    "by_object",
    "check_method",
    "from_ids",
    "from_nvdiffrast",
    "from_open3d",
    "from_png",
    "from_pyrender",
    "modelled",
    "read_map",
]
