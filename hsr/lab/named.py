"""Scenes by what they are called: files, built-in scenes, and hard cases."""

from __future__ import annotations

from pathlib import Path

from hsr.base.errors import SceneError, named, nearest
from hsr.problem.view import load as load_file
from hsr.scene.files import built_in
from hsr.scene.model import Scene

SIDE = 512
"""Of the picture that a hard case is made for, in samples: what verbs draw unasked."""


def load(path: str | Path) -> Scene:
    """Read a scene or mesh file, or make a hard case by the name of its family.

    An existing file comes first, then a built-in scene. Hard cases are as hard as theirs is taken to be, for
    pictures of 512x512 samples; ``about`` says where another size is needed. For the rest see
    :func:`hsr.scene.files.load`.

    Raises
    ------
    SceneError
        With one line for each problem of the file and of the meshes it names.

    Examples
    --------
    >>> import hsr
    >>> [camera.type for camera in hsr.load("needle").camera]
    ['orthographic']
    """
    name = str(path)
    if Path(name).suffix or Path(name).exists() or name in built_in():
        return load_file(path)
    from hsr.lab.stability.cases import families  # takes long to import

    cases = families()
    if name not in cases and (nearest(name, built_in()) or not nearest(name, cases)):
        return load_file(path)
    case = named(name, cases, "there is no file, scene or hard case", SceneError)
    return case.scene_at(case.sweep[-1], SIDE).located(Path(), name)
