"""The page of a lesson, and the page that lists all lessons."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hsr.base.files import write_whole
from hsr.lessons.lesson import lesson_of
from hsr.lessons.topics import Topic
from hsr.pages.frame import page, style
from hsr.pages.packing import pack_json
from hsr.scene.model import Scene


def write_lesson(
    topic: Topic, path: str | Path, scene: Scene | None = None, beside: Mapping[str, str] | None = None
) -> None:
    """Write a lesson as one HTML file that needs no network.

    Parameters
    ----------
    scene : Scene, optional
        In place of the topic's own.
    beside : mapping of str to str, optional
        What the page leads to, and where that lies.

    Raises
    ------
    HsrError
        If the scene is too large to be recorded, or the file cannot be written.
    """
    told: dict[str, Any] = {"lead": topic.lead, "recording": pack_json(lesson_of(topic, scene))}
    text = page("lesson", path, topic.title, style("lesson.css"), ["lesson.js"], beside=beside, **told)
    write_whole(path, text, "the lesson")


def write_course(course: Mapping[str, Topic], folder: str | Path) -> None:
    """Write lessons, and a page that leads to them, into a folder.

    Parameters
    ----------
    course : mapping of str to Topic
        File ``NAME.html`` for each name.
    folder : str or Path
        There already; files in it are replaced.

    Raises
    ------
    HsrError
        If a file cannot be written.
    """
    path = Path(folder, "index.html")
    title = "Which surface does the eye see? A course"
    write_whole(path, page("course", path, title, style("course.css"), course=course), "the list of lessons")
    for name, topic in course.items():
        write_lesson(topic, Path(folder, f"{name}.html"), beside={"Lessons": "index.html"})
