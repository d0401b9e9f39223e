"""A view in exact numbers, ready to be decided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hsr.base.arrays import Array
from hsr.exact.decide import Piece
from hsr.exact.filter import TriangleTables, triangle_tables
from hsr.exact.numbers import Frame, frame_of, samples
from hsr.exact.planes import Triangles, triangles_of
from hsr.exact.quadrics import Round, rounds_of
from hsr.problem.view import View


@dataclass(frozen=True, eq=False)
class Problem:
    """All that may be seen in a view.

    Attributes
    ----------
    frame : Frame
    triangles : Triangles
    tables : TriangleTables
        The triangles in float64.
    rounds : sequence of Round
        Numbered on from the triangles.
    i, j : (W,), (H,) int64
        Coordinates of the columns and rows.
    """

    frame: Frame
    triangles: Triangles
    tables: TriangleTables
    rounds: Sequence[Round]
    i: Array
    j: Array

    def at(self, sample: Array) -> tuple[Array, Array]:
        """Return the coordinates of samples numbered row after row."""
        width = len(self.i)
        return self.i[sample % width], self.j[sample // width]

    def exactly_at(self, sample: Array) -> tuple[Array, Array]:
        """Return the same coordinates as Python integers, which do not overflow."""
        i, j = self.at(sample)
        return i.astype(object), j.astype(object)

    def piece(self, number: int) -> Piece:
        """Return a piece by its number."""
        flat = len(self.triangles)
        return self.triangles.piece(number) if number < flat else self.rounds[number - flat].piece


def problem_of(view: View) -> Problem:
    """Set a view up in exact numbers.

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along its lines of sight.
    """
    frame = frame_of(view)
    triangles = triangles_of(view, frame)
    tables = triangle_tables(triangles, frame.nearer, view.width, view.height)
    return Problem(frame, triangles, tables, rounds_of(view, frame, len(triangles)), *samples(view))
