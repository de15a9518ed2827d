"""What goes in and comes out as the texts of files."""

from __future__ import annotations

import io
import json
import os
from typing import Any, Dict, Mapping, Tuple, Union

from ._mle import ProcessModel, StateSpaceModel, StepResponseModel
from .errors import _error


class FileResult:
    """A result that is the files of a command, by name."""

    _JSON = ""  # the name of the one in JSON

    def __init__(self, files: Dict[str, str]) -> None:
        self._files = files

    def to_json(self) -> str:
        """The text of the JSON file that the command writes (docs/formats.md)."""
        return self._files[self._JSON]

    def to_dict(self) -> Dict[str, Any]:
        """The same as Python's objects."""
        return json.loads(self.to_json())

    def report_html(self) -> str:
        """The text of the page report.html."""
        return self._files["report.html"]

    def report(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the page to ``path``."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.report_html())

    def _frame(self, name: str) -> Any:
        import pandas as pd

        return pd.read_csv(io.StringIO(self._files[name]), float_precision="round_trip")


def _plain(value: Any) -> Any:
    """What json cannot write: models, arrays, paths."""
    if isinstance(value, (StepResponseModel, StateSpaceModel)):
        value = value.process
    if isinstance(value, ProcessModel):
        return json.loads(value.to_json())
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def text_and_source(
    content: Union[Mapping[str, Any], str, "os.PathLike[str]"], name: str
) -> Tuple[str, str, str, str]:
    """Of a mapping, or of the path of a file: its text, what messages call it, the
    folder of the file names in it, and how it is shown in a call."""
    if isinstance(content, Mapping):
        return json.dumps(content, default=_plain), name, "", name
    path = os.fspath(content)
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not a text in UTF-8 ({error.reason})") from None
    except OSError as error:
        code = "NOT_FOUND" if isinstance(error, FileNotFoundError) else "UNAVAILABLE"
        raise _error(code, f"{path}: cannot be read: {error.strerror}", "") from None
    return text, path, os.path.join(os.path.dirname(path), ""), repr(path)
