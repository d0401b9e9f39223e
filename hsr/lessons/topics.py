"""What a lesson says: its tracks, its formulas, its screens and its question, read from ``topics/*.toml``."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hsr.base.errors import named


class Part(BaseModel):
    """Base of every part of a topic: frozen, no unknown key."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Track(Part):
    """One run of a method, or of two side by side.

    Attributes
    ----------
    label : str
    scene : str
        File in ``scenes/``.
    methods : tuple of str
        One or two names that ``hsr algos`` lists.
    options : dict
        Of the methods, in place of their own.
    camera : str, optional
    size : (width, height)
        In samples.
    backwards : bool
        Whether the objects come in the opposite order.
    """

    label: str
    scene: str
    methods: Annotated[tuple[str, ...], Field(min_length=1, max_length=2)]
    options: dict[str, Any] = {}
    camera: str | None = None
    size: tuple[int, int] = (16, 12)
    backwards: bool = False


class Formula(Part):
    """What to say when a line has run.

    In ``text``, ``{name}`` is a variable's value after it, ``{~name}`` the one before.
    """

    line: str
    text: str


class Screen(Part):
    """One idea.

    Attributes
    ----------
    title, text, formula : str
    track : str, optional
        The label of the track to change to.
    line : str, optional
        The statement to go to, as it begins in the listing.
    nth : int
        At which of its runs, counted from 1.
    """

    title: str
    text: str
    formula: str = ""
    track: str | None = None
    line: str | None = None
    nth: Annotated[int, Field(ge=1)] = 1


class Question(Part):
    """The question at the end; ``answer`` is the place of the right choice."""

    text: str
    choices: tuple[str, ...]
    answer: int
    why: str

    @model_validator(mode="after")
    def _has_its_answer(self) -> Question:
        if not 0 <= self.answer < len(self.choices):
            raise ValueError(f"answer {self.answer}: there are {len(self.choices)} choices")
        return self


class Topic(Part):
    """A lesson without its recordings.

    Attributes
    ----------
    title, lead : str
    order : int
        Its place in the course.
    prompt : str
        What is asked before a turn.
    predictions : int
        How often a track asks, at most.
    track, formula, screen, question
    """

    title: str
    lead: str
    order: int
    prompt: str
    predictions: Annotated[int, Field(ge=0)]
    track: Annotated[tuple[Track, ...], Field(min_length=1)]
    formula: tuple[Formula, ...] = ()
    screen: Annotated[tuple[Screen, ...], Field(min_length=1)]
    question: Question

    @model_validator(mode="after")
    def _tracks_exist(self) -> Topic:
        labels = [track.label for track in self.track]
        for screen in self.screen:
            if screen.track is not None and screen.track not in labels:
                raise ValueError(f"screen {screen.title!r}: no track is labelled {screen.track!r}")
        return self


def topics() -> dict[str, Topic]:
    """Return all topics by name, in the order of the course."""
    folder = files("hsr.lessons").joinpath("topics")
    found = {
        file.name.removesuffix(".toml"): Topic.model_validate(tomllib.loads(file.read_text(encoding="utf-8")))
        for file in folder.iterdir()
    }
    return dict(sorted(found.items(), key=lambda item: item[1].order))


def topic_named(name: str) -> Topic:
    """Return one topic.

    Raises
    ------
    HsrError
        If there is no such topic.
    """
    return named(name, topics(), "no lesson is about")
