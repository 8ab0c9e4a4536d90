"""A desk: one student's work on one lab in one session, the same for every front end.

It keeps the last settings, the preset pressed last, the files given, the pictures (axes and background drawn once) and the last result.
"""

import shutil
import tempfile
import weakref
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from gnsslab.labs.controls import FileOrPath

NAME_AT_MOST = 60  # characters: four bytes each are still less than the 255 that a disk allows


class Upload(NamedTuple):
    """A file that a student gave."""

    path: str  # where it is kept in this session
    contents: bytes


class Desk:
    """Settings, files, pictures and the last result of one lab in one session."""

    def __init__(self, lab):
        self.lab = lab
        self.settings = lab.defaults
        self.result = None
        self._pressed = None  # preset whose settings the controls had last
        self._pictures = None
        self._folder = None
        self._uploads = {}  # control name -> the Upload given last

    def press(self, preset):
        """Set the controls to a preset; the student's own files stay."""
        files = {name: self.settings[name] for name in self._file_names()}
        self.settings = self.lab.defaults | files | dict(preset.settings)
        self._pressed = preset

    def run(self, settings):
        """Return the lab's result at the settings, the last of which are kept; a sentence names uploads as the student does."""
        self.settings = self.settings | settings
        result = self.lab.run(**self.settings)
        self.result = replace(result, problem=self._with_own_names(result.problem)) if result.problem else result
        return self.result

    @property
    def pressed(self):
        """The preset whose settings the controls have; None once a control was moved."""
        preset = self._pressed
        if preset is None or any(self.settings[name] != value for name, value in self._of_preset(preset).items()):
            return None
        return preset

    @property
    def blocked(self):
        """Controls without effect at the present settings, each with the reason."""
        return self.lab.blocked(self.settings)

    def pictures(self, result):
        """Return the lab's pictures of a result: pairs of Drawing and PNG bytes."""
        from gnsslab.figures.kept import KeptPicture

        if self._pictures is None:
            self._pictures = [(drawing, KeptPicture(drawing.build, drawing.width, drawing.height)) for drawing in self.lab.drawings()]
        return [(drawing, picture.png(result)) for drawing, picture in self._pictures]

    def given_file(self, name, typed, upload=None):
        """Return the path that a file control stands for: a new upload (name, contents), else what was typed, else the last upload."""
        if upload is not None:
            return self._stored(name, *upload)
        if typed:
            self._uploads.pop(name, None)
        return typed or (self._uploads[name].path if name in self._uploads else "")

    def uploaded_name(self, name):
        """Return the name of the file uploaded for a control, "" where there is none."""
        return Path(self._uploads[name].path).name if name in self._uploads else ""

    def _of_preset(self, preset):
        return {name: value for name, value in (self.lab.defaults | dict(preset.settings)).items() if name not in self._file_names()}

    def _file_names(self):
        return [control.name for control in self.lab.controls if isinstance(control, FileOrPath)]

    def _with_own_names(self, sentence):
        """Return a sentence in which an upload goes by its control's label and its own name, not by where it is kept."""
        for name, upload in self._uploads.items():
            sentence = sentence.replace(upload.path, f"{self.lab.control(name).label} ({Path(upload.path).name})")
        return sentence

    def _stored(self, name, filename, contents):
        """Write an upload into this session's folder, which goes when the session goes; return its path."""
        known = self._uploads.get(name)
        if known is None or known.contents is not contents:
            folder = self._own_folder() / name
            shutil.rmtree(folder, ignore_errors=True)  # a desk keeps one upload for each control
            folder.mkdir()
            path = folder / _plain_name(filename)
            path.write_bytes(contents)
            self._uploads[name] = Upload(str(path), contents)
        return self._uploads[name].path

    def _own_folder(self):
        if self._folder is None:
            self._folder = tempfile.mkdtemp(prefix="gnsslab-")
            weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        return Path(self._folder)


def _plain_name(filename):
    """Return the name of an upload as that of a file in its own folder: no way out of it, and not too long for a disk.

    >>> _plain_name("../../rover.24o"), _plain_name("..")
    ('rover.24o', 'file')
    """
    name = Path(filename.replace("\0", "")).name
    return "file" if name in ("", "..") else name[-NAME_AT_MOST:]
