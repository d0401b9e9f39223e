"""The page of a lesson, and the page that lists all lessons."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from pathlib import Path

from hsr.base.files import write_whole
from hsr.lessons.lesson import lesson_of
from hsr.lessons.topics import Topic
from hsr.pages.page import part, policy, style, templates
from hsr.scene.model import Scene


def write_lesson(topic: Topic, path: str | Path, scene: Scene | None = None) -> None:
    """Write a lesson as one HTML file that needs no network.

    Parameters
    ----------
    topic : Topic
    path : str or Path
    scene : Scene, optional
        In place of the topic's own.

    Raises
    ------
    HsrError
        If the scene is too large to be recorded, or the file cannot be written.
    """
    recording = json.dumps(lesson_of(topic, scene), ensure_ascii=False, separators=(",", ":"))
    packed = zlib.compress(recording.encode("utf-8"), 9)
    sheet, script = style("lesson.css"), part("lesson.js")
    page = (
        templates()
        .get_template("lesson.html")
        .render(
            title=topic.title,
            lead=topic.lead,
            recording=base64.b64encode(packed).decode("ascii"),
            style=sheet,
            script=script,
            policy=policy(sheet, script),
        )
    )
    write_whole(path, page, "the lesson")


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
    for name, topic in course.items():
        write_lesson(topic, Path(folder, f"{name}.html"))
    sheet = style("course.css")
    page = templates().get_template("course.html").render(course=course, style=sheet, policy=policy(sheet))
    write_whole(Path(folder, "index.html"), page, "the list of lessons")
