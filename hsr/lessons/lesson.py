"""A lesson with its recordings: all that a page needs to play it."""

from __future__ import annotations

import math
import string
from collections.abc import Sequence
from importlib.resources import as_file, files
from typing import Any

import numpy as np

from hsr.algorithms.registry import Method, method_named
from hsr.algorithms.registry import render as render_by
from hsr.base.errors import MethodError
from hsr.lessons.listing import begins
from hsr.lessons.recording import Recording, Turn, record
from hsr.lessons.topics import Formula, Screen, Topic, Track
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View, view
from hsr.scene.files import load
from hsr.scene.model import Scene

MOST_FACES = 48
"""Faces of a scene that a lesson records, a sphere's many flat ones counted singly where it is cut into them:
more would fill hours of stepping."""

LETTERS = string.ascii_uppercase + string.ascii_lowercase
"""What faces are called in a cell of a picture."""

LIGHT = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#44bb99", "#bbcc33", "#99ddff", "#dddddd")
"""Paul Tol's light scheme: colours to stand behind black letters, told apart by people who see no red or no
green as well (SRON technical note 09-002)."""


def lesson_of(topic: Topic, scene: Scene | None = None) -> dict[str, Any]:
    """Record the tracks of a topic.

    Parameters
    ----------
    topic : Topic
    scene : Scene, optional
        To be seen in place of the topic's own, by its first camera. Tracks that differ in scene or camera
        only become one.

    Returns
    -------
    dict
        JSON values: ``title``, ``lead``, ``prompt``, ``tracks``, ``screens`` and ``question``.

    Raises
    ------
    MethodError
        If the scene is too large to be recorded.
    """
    tracks = _tracks(topic, scene)
    names: dict[str, dict[str, int]] = {track.scene: {} for track in tracks}
    recorded = [_recorded(topic, track, scene, names[track.scene]) for track in tracks]
    labels = [track.label for track in tracks]
    return {
        **topic.model_dump(include={"title", "lead", "prompt"}),
        "tracks": recorded,
        "screens": [_screen(screen, labels, recorded) for screen in topic.screen],
        "question": topic.question.model_dump(),
    }


def _tracks(topic: Topic, scene: Scene | None) -> list[Track]:
    """Return the tracks to record: with a scene from outside, those that still differ."""
    if scene is None:
        return list(topic.track)
    distinct: dict[str, Track] = {}
    for track in topic.track:
        settings = track.model_dump(exclude={"label", "scene", "camera", "size"})
        distinct.setdefault(str(settings), track.model_copy(update={"camera": None, "size": (16, 12)}))
    return list(distinct.values())


def _recorded(topic: Topic, track: Track, scene: Scene | None, names: dict[str, int]) -> dict[str, Any]:
    """Record one track; ``names``, shared by the tracks of a scene, grows by those of its faces."""
    problem, methods = view_of(track, scene), [method_named(name) for name in track.methods]
    problem = problem if all(method.curved for method in methods) else problem.tessellated()
    _check_faces(problem)
    panels = [record_by(problem, method, track.options) for method in methods]
    ties = render_by(problem, "exact").admissible
    return {
        "label": track.label,
        "width": problem.width,
        "height": problem.height,
        "faces": {face: _face(panels[0].answer.name_of(face), names) for face in _faces_seen(panels)},
        "ties": [] if ties is None else ties.sample.tolist(),
        "asked": [turn._asdict() for turn in asked(panels[0].turns, topic.predictions)],
        "panels": [
            panel(name, recording, topic.formula)
            for name, recording in zip(track.methods, panels, strict=True)
        ],
    }


def view_of(track: Track, scene: Scene | None = None) -> View:
    """Return what a track sees: its own scene, or another."""
    if scene is None:
        with as_file(files("hsr.lessons").joinpath("scenes", track.scene)) as path:
            scene = load(path)
    if track.backwards:
        scene = scene.model_copy(update={"object": tuple(reversed(scene.object))})
    return view(scene, track.size, track.camera)


def record_by(problem: View, method: Method, options: dict[str, Any]) -> Recording:
    """Record a method by the probe of its row.

    Raises
    ------
    MethodError
        If its row names none.
    """
    probe = method.load_probe()
    if probe is None:
        raise MethodError(f"{method.name} cannot be recorded: its row names no probe")
    return record(problem, method, probe(problem, method.options(**options)), **options)


def _check_faces(problem: View) -> None:
    count = problem.faces if problem.curved else len(problem.polygons)
    if count > MOST_FACES:
        told = f"{count:,} faces are too many to follow step by step, {MOST_FACES} is the most"
        raise MethodError(f"{told}; scenes/cube.toml has 6")


def asked(turns: Sequence[Turn], most: int) -> list[Turn]:
    """Choose turns to ask about: of those in which faces compete, as many won by each face."""
    contested = [turn for turn in turns if len(turn.faces) > 1 and turn.owner in turn.faces]
    winners = sorted({turn.owner for turn in contested})
    chosen: list[Turn] = []
    for k, winner in enumerate(winners):
        won = [turn for turn in contested if turn.owner == winner]
        share = (most - len(chosen)) // (len(winners) - k)
        # The middles of equal parts: neither the first, which is seen being explained, nor the last.
        chosen += [won[(2 * part + 1) * len(won) // (2 * share)] for part in range(min(share, len(won)))]
    return sorted(chosen)


# ---------------------------------------------------------------- faces


def _faces_seen(panels: Sequence[Recording]) -> list[int]:
    """Return the faces that occur, in order."""
    written = {face for recording in panels for step in recording.steps for _, face, _ in step.writes}
    met = {face for recording in panels for turn in recording.turns for face in turn.faces}
    return sorted((written | met) - {BACKGROUND})


def _face(name: str, names: dict[str, int]) -> dict[str, str]:
    """Describe a face by its name; its letter and colour are those of the name's place among all."""
    place = names.setdefault(name, len(names))
    return {"letter": LETTERS[place % len(LETTERS)], "name": name, "colour": LIGHT[place % len(LIGHT)]}


# ---------------------------------------------------------------- panels


def panel(name: str, recording: Recording, formulas: Sequence[Formula]) -> dict[str, Any]:
    """Return a recording as JSON values, its numbers as people read them.

    ``changes`` and ``writes`` hold, for every step, a flat list: slot, value, slot, value, ...; and sample,
    face, depth, ...
    """
    write_depth = depth_writer([depth for step in recording.steps for _, _, depth in step.writes])
    listing = recording.listing
    functions = {index: function for (function, _), index in listing.place.items()}
    return {
        "method": name,
        "about": method_named(name).about,
        "listing": listing.text,
        "functions": [functions.get(index, "") for index in range(len(listing.text))],
        "slots": recording.slots,
        "lines": [step.line for step in recording.steps],
        "changes": [
            [part for slot, value in step.changes for part in (slot, readable(value))]
            for step in recording.steps
        ],
        "writes": [
            [part for sample, face, depth in step.writes for part in (sample, face, write_depth(depth))]
            for step in recording.steps
        ],
        "turns": [[turn.step, turn.sample] for turn in recording.turns],
        "counters": recording.counters,
        "formulas": {k: formula.text for formula in formulas for k in listing.lines(formula.line)},
    }


def readable(value: Any) -> str:
    """Write a variable's value: floats to four figures, long integers in hexadecimal."""
    if isinstance(value, list):
        return f"({', '.join(readable(part) for part in value)})"
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, float):
        return "–" if math.isnan(value) else f"{value:.4g}".replace("inf", "∞").replace("-", "−")
    if isinstance(value, int) and abs(value) > 2**31:
        return f"{value:#x}"
    return str(value).replace("-", "−")


def depth_writer(depths: Sequence[float]) -> Any:
    """Return what writes depths for the cells of a picture: as few figures as tell them apart.

    Whole numbers stay whole. Others get as many decimals as show a hundredth of their range; the 0 before the
    point is left out.
    """
    finite = np.unique([depth for depth in depths if math.isfinite(depth)])
    if all(depth == int(depth) for depth in finite) and finite.max(initial=0.0) > 1.0:
        decimals = 0
    else:
        extent = float(np.ptp(finite)) if len(finite) > 1 else 1.0
        decimals = min(max(math.ceil(2.0 - math.log10(extent)), 1), 9)

    def write(depth: float) -> str:
        if math.isinf(depth):
            return "∞"
        text = f"{depth:.{decimals}f}"
        return text[1:] if text.startswith("0.") else text

    return write


# ---------------------------------------------------------------- screens


def _screen(screen: Screen, labels: Sequence[str], tracks: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return a screen as JSON values: of each track, the step to go to."""
    track = labels.index(screen.track) if screen.track in labels else None
    steps = [step_of(screen, recorded["panels"][0]) for recorded in tracks]
    return screen.model_dump(include={"title", "text", "formula"}) | {"track": track, "steps": steps}


def step_of(screen: Screen, panel: dict[str, Any]) -> int:
    """Return the step a screen begins with: that run of its line, else the last one, else the first step."""
    if screen.line is None:
        return 0
    runs = [k for k, line in enumerate(panel["lines"]) if begins(panel["listing"][line], screen.line)]
    return runs[min(screen.nth, len(runs)) - 1] if runs else 0
