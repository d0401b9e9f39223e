"""Readers of mesh files: OBJ, OFF, PLY, STL and glTF, one file a format.

What a file announces (faces, corners, facets) is counted against what is there: a file that was cut off
is refused with the line or the byte. Faces are numbered as the file lists them, whatever groups and
materials they belong to.
"""

from __future__ import annotations

from pathlib import Path

from hsr.scene.meshes import Faces
from hsr.scene.readers.obj import read_obj
from hsr.scene.readers.off import read_off
from hsr.scene.readers.ply import read_ply
from hsr.scene.readers.source import content_of, ending_of, reading
from hsr.scene.readers.stl import read_stl

READERS = {".obj": read_obj, ".off": read_off, ".ply": read_ply, ".stl": read_stl}


def read_faces(path: Path) -> Faces:
    """Read an OBJ, OFF, PLY or STL file.

    While it reads, it holds at most 20 bytes for each byte of the file, unpacked; 100 if that is strips.

    Parameters
    ----------
    path : Path
        The ending of its name, in upper or lower case, says which format it is; ``.gz`` may follow.

    Raises
    ------
    SceneError
        If the file does not follow its format; the message does not name the file.
    OSError
        If it cannot be read at all.
    """
    with reading(path):
        return READERS[ending_of(path)](content_of(path))
