"""Scenes written as TOML: what :func:`hsr.load` reads back to the same numbers, bit by bit."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hsr.base.errors import SceneError
from hsr.base.files import write_whole
from hsr.scene.model import Mesh, Scene
from hsr.scene.values import Description

INDENT = "  "


def to_toml(scene: Scene, explained: bool = False) -> str:
    """Write a scene as TOML.

    Only the keys that were given are written, not the defaults. Names of mesh files stay as they
    are: relative to ``scene.folder``.

    Parameters
    ----------
    scene : Scene
    explained : bool
        Whether to write above each key what it says, and the keys that were not given as comments.

    Returns
    -------
    str
        Its floats have as many digits as tell them from every other float64.
    """
    # Unset, not default: -0.0 equals 0.0, and yet is another number.
    tables = {"hsr": scene.hsr, **scene.model_dump(exclude_unset=True, exclude_none=True)}
    plain = {key: value for key, value in tables.items() if not _is_tables(value)}
    write = _explained if explained else _table
    parts = [write(plain, scene)]
    for key, value in tables.items():
        if _is_tables(value):
            parts += [f"[[{key}]]\n{write(*pair)}" for pair in zip(value, getattr(scene, key), strict=True)]
    return "\n".join(parts)


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene file, .toml.

    Raises
    ------
    SceneError
        If the file cannot be written.
    """
    write_whole(path, to_toml(scene), "the scene", SceneError)


def with_files(scene: Scene, name: Callable[[str], str]) -> Scene:
    """Return a scene whose mesh files are named in another way, such as from another folder."""
    things = (
        one.model_copy(update={"file": name(one.file)}) if isinstance(one, Mesh) and one.file else one
        for one in scene.object
    )
    return scene.model_copy(update={"object": tuple(things)})


def _is_tables(value: Any) -> bool:
    return isinstance(value, tuple) and bool(value) and isinstance(value[0], Mapping)


def _table(table: Mapping[str, Any], _: Description) -> str:
    return "".join(f"{key} = {_rows(value)}\n" for key, value in table.items())


def _explained(table: Mapping[str, Any], part: Description) -> str:
    """Write a table with what its keys say; those that it has not, with their defaults, are comments."""
    lines = []
    for key, field in type(part).model_fields.items():
        if key in table:
            lines.append(f"# {field.description}\n{key} = {_rows(table[key])}\n")
        elif not isinstance(part, Scene) or key not in ("camera", "object", "light"):  # they follow
            default = "" if field.default is None else _rows(field.default)
            lines.append(f"# {field.description}\n# {key} = {default}".rstrip() + "\n")
    return "".join(lines)


def _rows(value: Any) -> str:
    """Write the value of a key; a list of lists or of tables goes one to a line."""
    if isinstance(value, tuple) and value and isinstance(value[0], tuple | Mapping):
        return "[\n" + "".join(f"{INDENT}{_inline(entry)},\n" for entry in value) + "]"
    return _inline(value)


def _inline(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_inline(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return _string(value) if isinstance(value, str) else repr(value)


def _string(text: str) -> str:
    """Write a basic string: JSON's escapes are TOML's, but for the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
