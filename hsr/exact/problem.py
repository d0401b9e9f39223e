"""A view in exact numbers, ready to be decided."""

from __future__ import annotations

from dataclasses import dataclass

from hsr.base.arrays import Array
from hsr.exact.decide import Piece
from hsr.exact.filter import TriangleTables, triangle_tables
from hsr.exact.numbers import Frame, frame_of
from hsr.exact.planes import Triangles, triangles_of
from hsr.exact.quadrics import rounds_of
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
    rounds : list of Piece
        The curved ones, numbered on from the triangles.
    """

    frame: Frame
    triangles: Triangles
    tables: TriangleTables
    rounds: list[Piece]

    def piece(self, number: int) -> Piece:
        """Return a piece by its number."""
        flat = len(self.triangles)
        return self.triangles.piece(number) if number < flat else self.rounds[number - flat]


def problem_of(view: View, samples: Array) -> Problem:
    """Set up in exact numbers what can be seen at some samples of a view.

    Parameters
    ----------
    view : View
    samples : (n,) int64
        Numbers ``row * W + column``; triangles that cover none of them are left out.

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along its lines of sight.
    """
    frame = frame_of(view)
    triangles = triangles_of(view, frame, samples)
    tables = triangle_tables(triangles, frame.nearer, view.width, view.height)
    return Problem(frame, triangles, tables, rounds_of(view, frame, len(triangles)))
