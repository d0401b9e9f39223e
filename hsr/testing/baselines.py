"""Stored baselines: small files beside the test, several where several answers are valid.

A baseline of map ``name`` is ``name.npz``, a visibility map; further valid answers are ``name~2.npz``,
``name~3.npz`` and so on. Depths are stored only where a test judges them: ids are small, depths are not.
``name.json`` in their place holds content hashes alone.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from pydantic import TypeAdapter

from hsr.base.errors import CheckError, MapError, told_briefly
from hsr.base.files import write_whole
from hsr.problem.map import BACKGROUND, NO_DEPTH, VisibilityMap, load_map
from hsr.testing.judging import Judgement, Subject, judge
from hsr.testing.limits import Limits

FORMAT = 1
"""The version of a file of hashes."""

FOLDER = "__visibility__"
"""Beside a test module; has a folder of baselines for each module."""

DEPTHS = "depths"
"""The note in which a baseline without depths keeps their hash."""

KEPT_NOTES = ("driver", "depth_format")
"""What a baseline keeps of a map's notes; the rest may change without meaning."""

ANEW = "delete it, and write it anew with --hsr-update=new"

SUFFIXES = {"maps": ".npz", "hashes": ".json"}
"""What is kept of a map, and in which kind of file."""

PLAIN = re.compile(r"[a-z0-9_-]{1,80}")
RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)")

Kind = TypeVar("Kind")

Contents = dict[str, str]
"""Content hashes and names: ``faces``, ``depths``, ``scene``, ``camera``, ``size``, ``renderer``."""


# ---------------------------------------------------------------- names


def file_stem(*parts: str) -> str:
    """Return a file name, without its ending, that every file system takes.

    Parameters
    ----------
    *parts : str
        The name of a test, its parameters among it, and that of a check.

    Returns
    -------
    str
        The parts joined by points if they are plain: lower case, digits, ``_`` and ``-``, not too
        long. Else what is plain of them and a hash, so that different parts have different names even
        where upper and lower case are one.
    """
    text = ".".join(parts)
    if all(PLAIN.fullmatch(part) and not RESERVED.fullmatch(part) for part in parts) and len(text) <= 80:
        return text
    digest = hashlib.sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()
    return f"{re.sub(r'[^a-z0-9_-]+', '-', text.lower()).strip('-')[:60]}-{digest[:12]}"


def variants(folder: Path, stem: str) -> list[Path]:
    """Return the baselines of one name, by number."""
    pattern = re.compile(re.escape(stem) + r"(~\d+)?\.(npz|json)")
    found = [file for file in folder.glob(f"{stem}*") if pattern.fullmatch(file.name)]
    return sorted(found, key=lambda file: (_number(file), file.name))


def _number(file: Path) -> int:
    return int(file.stem.partition("~")[2] or 1)


def next_variant(folder: Path, stem: str, suffix: str) -> Path:
    """Return the path of one more valid baseline."""
    number = max(map(_number, variants(folder, stem)), default=0) + 1
    return folder / f"{stem}{'' if number == 1 else f'~{number}'}{suffix}"


# ---------------------------------------------------------------- contents


def contents(map: VisibilityMap) -> Contents:
    """Hash what a map holds: faces, depths, scene and camera apart.

    Parameters
    ----------
    map : VisibilityMap

    Returns
    -------
    dict of str to str
        SHA-256 of ``faces`` (int32) and ``depths`` (float64), little-endian, row by row; of ``scene``
        and ``camera`` where the map tells; ``size`` and ``renderer`` in words.
    """
    driver = map.notes.get("driver", "")
    return {
        "faces": hashlib.sha256(map.face.astype("<i4").tobytes()).hexdigest(),
        "depths": map.notes.get(DEPTHS) or hashlib.sha256(map.depth.astype("<f8").tobytes()).hexdigest(),
        "scene": map.hashes.get("scene", ""),
        "camera": map.hashes.get("camera", ""),
        "size": f"{map.width}x{map.height}",
        "renderer": f"{map.method} ({driver})" if driver else map.method,
    }


def changes(old: Contents, new: Contents) -> str:
    """Say in one line what has changed since a baseline was written."""
    words = []
    for what in ("scene", "camera", "depths"):
        known = old[what] and new[what]
        words.append(f"{what} {'unknown' if not known else 'same' if old[what] == new[what] else 'changed'}")
    for what in ("size", "renderer"):
        same = old[what] == new[what]
        words.append(f"{what} same" if same else f"{what} changed from {old[what]} to {new[what]}")
    return ", ".join(words)


def write(file: Path, map: VisibilityMap, depths: bool) -> None:
    """Write a baseline; the same answer gives the same bytes.

    Parameters
    ----------
    file : Path
        Its ending says what is kept: ``.npz`` the map, ``.json`` hashes alone.
    map : VisibilityMap
    depths : bool
        Whether to keep the depths of a map.

    Raises
    ------
    HsrError
        If the file cannot be written, or a link leads elsewhere.
    """
    held = contents(map)
    check_place(file)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CheckError(f"{file}: cannot write the baseline: {error.strerror}") from error
    if file.suffix == ".json":
        write_whole(file, json.dumps({"hsr": FORMAT, **held}, indent=2) + "\n", "the baseline", CheckError)
        return
    notes: dict[str, Any] = {name: map.notes[name] for name in KEPT_NOTES if name in map.notes}
    if not depths:
        notes |= {DEPTHS: held["depths"], "depth_format": NO_DEPTH}
        map = replace(map, depth=np.where(map.face == BACKGROUND, np.inf, np.nan))
    replace(map, work={}, notes=notes).save(file)


def check_place(file: Path) -> None:
    """Refuse a baseline that a link would have written elsewhere: its folders, or the file, are links.

    Raises
    ------
    CheckError
        If it is.
    """
    file = file.absolute()
    if file.resolve() != Path(file.parents[2].resolve(), *file.parts[-3:]):
        raise CheckError(f"{file}: a link leads to {file.resolve()}; nothing is written there")


def read(file: Path) -> VisibilityMap | Contents:
    """Read a baseline, a map or hashes.

    Raises
    ------
    HsrError
        If the file is damaged, or no baseline.
    """
    if file.suffix != ".json":
        try:
            return load_map(file)
        except MapError as error:
            raise CheckError(f"{error}; {ANEW}") from None
    held = read_json(dict[str, Any], file, "not a baseline", f"; {ANEW}")
    known = ("faces", "depths", "scene", "camera", "size", "renderer")
    fits = held.pop("hsr", None) == FORMAT and sorted(held) == sorted(known)
    if not fits or not all(isinstance(value, str) for value in held.values()):
        raise CheckError(f"{file}: not a baseline of version {FORMAT}; {ANEW}")
    return held


def read_json(kind: type[Kind], file: Path, complaint: str, remedy: str = "") -> Kind:
    """Read a file of JSON as values of a kind; :class:`CheckError` if that fails."""
    try:
        return TypeAdapter(kind).validate_json(file.read_bytes())
    except (OSError, ValueError) as error:
        raise CheckError(f"{file}: {complaint} ({told_briefly(error)}){remedy}") from None


# ---------------------------------------------------------------- matching


class Match(NamedTuple):
    """How a map compares with one baseline.

    Attributes
    ----------
    file : Path
    lines : tuple of str
        The judgement, for people.
    passed : bool
    judgement : Judgement or None
        None where only hashes are kept, or the size has changed.
    stored : VisibilityMap or None
        The baseline, where its size has changed.
    """

    file: Path
    lines: tuple[str, ...]
    passed: bool
    judgement: Judgement | None
    stored: VisibilityMap | None = None


def match(
    name: str, shown: VisibilityMap, files: Sequence[Path], limits: Limits, subject: Subject | None
) -> Match:
    """Compare a map with its baselines; any that matches will do.

    Parameters
    ----------
    name : str
        How the test calls the map.
    shown : VisibilityMap
    files : sequence of Path
        One at least.
    limits : Limits
    subject : Subject or None

    Returns
    -------
    Match
        Of the first baseline that matches, else of the one from which the fewest samples differ.

    Raises
    ------
    HsrError
        If a baseline cannot be read.
    """
    found = []
    for file in files:
        found.append(_matched(name, shown, file, limits, subject))
        if found[-1].passed:
            return found[-1]
    nearest = min(found, key=lambda found: found.judgement.counted if found.judgement else np.inf)
    if len(found) == 1:
        return nearest
    return nearest._replace(lines=(f"none of {len(found)} baselines matches; the nearest:", *nearest.lines))


def _matched(name: str, shown: VisibilityMap, file: Path, limits: Limits, subject: Subject | None) -> Match:
    stored = read(file)
    new = contents(shown)
    old = stored if isinstance(stored, dict) else contents(stored)
    told = f"  since {file.name} was written: {changes(old, new)}"
    if isinstance(stored, dict):
        return _matched_hashes(name, file, old, new, told, limits)
    if old["size"] != new["size"]:
        sizes = f"{name} vs {file.name}: {new['size']} is not {old['size']}"
        return Match(file, (sizes, told), False, None, stored)
    if limits.depth_ulps is not None and not stored.tells_depth:
        missing = f"{file.name} keeps no depths, and {limits.told('depth_ulps')} judges them"
        return Match(file, (f"{name}: {missing}; write it again with --hsr-update=failed",), False, None)
    # Scene and camera may have changed: that explains a difference, and is none.
    expected = replace(stored, hashes={}, method=file.name)
    judgement = judge(name, shown, expected, limits, subject)
    return Match(file, (judgement.text(), told), judgement.passed, judgement)


def _matched_hashes(name: str, file: Path, old: Contents, new: Contents, told: str, limits: Limits) -> Match:
    judged = ["faces", "size", *(["depths"] if limits.depth_ulps is not None else [])]
    changed = ", ".join(what for what in judged if old[what] != new[what])
    outcome = f"{changed} changed" if changed else "same hashes"
    hint = ("  hashes cannot tell which samples: keep maps, with hsr_baselines = maps",) if changed else ()
    return Match(file, (f"{name} vs {file.name}: {outcome}", told, *hint), not changed, None)
