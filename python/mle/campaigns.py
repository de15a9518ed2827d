"""Campaigns: many simulated corrections over a grid of plants, noise and methods."""

from __future__ import annotations

import html
import json
import operator
import os
from typing import Any, Dict, Mapping, Optional, Union

from . import _mle
from .correction import Progress
from .files import FileResult, text_and_source


class StudyResult(FileResult):
    """What :func:`study` found out: the files of mle_study (docs/formats.md)."""

    _JSON = "summary.json"

    @property
    def runs(self) -> Any:
        """A data frame with a row for each run: its place in the grid and its figures
        of merit (the columns of runs.csv)."""
        return self._frame("runs.csv").set_index("run")

    @property
    def summary(self) -> Any:
        """A data frame with a row for each cell of the grid and figure of merit: its
        distribution over the seeds (the columns of summary.csv)."""
        return self._frame("summary.csv")

    @property
    def failures(self) -> Dict[str, int]:
        """How many runs failed, by kind."""
        return self.to_dict()["failures"]

    @property
    def campaign(self) -> Dict[str, Any]:
        """The campaign with every file that it names read in."""
        return json.loads(self._files["campaign.json"])

    def __repr__(self) -> str:
        found = self.to_dict()
        failed = f", {found['failed']} failed" if found["failed"] else ""
        return f"<mle.StudyResult '{found['campaign']}': {found['runs']} runs{failed}>"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self)[1:-1])}</p>" + self.summary.to_html(
            float_format="{:.4g}".format, na_rep="", index=False
        )


def study(
    campaign: Union[Mapping[str, Any], str, "os.PathLike[str]"],
    *,
    out: Union[str, "os.PathLike[str]", None] = None,
    resume: bool = False,
    figures: bool = True,
    threads: int = 0,
    progress: Optional[Progress] = None,
) -> StudyResult:
    """Runs a campaign, as the command mle_study does with the threads of one process.

    ``campaign`` is the path of its file or what the file holds as a mapping
    (docs/formats.md: Campaign); models and plants in it may be :class:`ProcessModel`,
    and file names are relative to its folder, of a mapping to the working folder.

    The files are written to the folder ``out``; without one they are kept in the
    result alone. A campaign in ``out`` that was interrupted resumes with ``resume``.
    ``threads`` 0 stands for all processors; results do not depend on it.
    ``progress("runs", fraction)`` and Ctrl-C act as in :func:`correct`; the runs under
    way end after it.

    Raises InvalidInputError (a ValueError) naming the JSON path of what is wrong.
    """
    text, source, folder, shown = text_and_source(campaign, "campaign")
    threads = operator.index(threads)
    if threads < 0:
        raise ValueError(f"threads={threads}: it must be 0 or more")
    to = "" if out is None else os.fspath(out)
    files = _mle._study(
        text, source, folder, to, resume, figures, threads, f"mle.study({shown})", progress
    )
    return StudyResult(files)
