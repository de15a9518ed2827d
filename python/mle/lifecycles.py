"""The life of a model over years, under policies of keeping it up to date."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Mapping, Optional, Union

from . import _mle
from .correction import Progress
from .files import FileResult, text_and_source
from .model import ModelLike, given_model
from .options import help_on, option_texts, takes_keywords

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import LifecycleOptions


class LifecycleResult(FileResult):
    """What :func:`lifecycle` found out: the files of mle_lifecycle
    (docs/lifecycle.md)."""

    _JSON = "result.json"

    @property
    def changes(self) -> Any:
        """A data frame with a row for each set-point change of each life (the columns
        of lifecycle.csv)."""
        return self._frame("lifecycle.csv")

    @property
    def policies(self) -> Any:
        """A data frame with a row for each rate of ageing and policy: costs and what
        was done, as in result.json; the names of nested keys are joined by dots."""
        import pandas as pd

        rows = [
            {"ageing_rate": rate["ageing_rate"], **policy}
            for rate in self.to_dict()["rates"]
            for policy in rate["policies"]
        ]
        return pd.json_normalize(rows)

    def __repr__(self) -> str:
        rates = self.to_dict()["rates"]
        names = [policy["policy"] for policy in rates[0]["policies"]]
        return f"<mle.LifecycleResult: {len(rates)} rates of ageing, {', '.join(names)}>"

    def _repr_html_(self) -> str:
        return self.policies.to_html(float_format="{:.4g}".format, na_rep="", index=False)


@takes_keywords(_mle._lifecycle_options())
def lifecycle(
    model: ModelLike,
    ageing: Union[Mapping[str, Any], str, "os.PathLike[str]"],
    plant: Optional[ModelLike] = None,
    *,
    out: Union[str, "os.PathLike[str]", None] = None,
    progress: Optional[Progress] = None,
    **options: Unpack[LifecycleOptions],
) -> LifecycleResult:
    """Lets a plant age over years under predictive control, and compares policies of
    keeping the controller's model up to date, as the command mle_lifecycle does.

    ``model`` is the controller's, ``plant`` what is true in the beginning (None:
    ``model``), ``ageing`` the path of a schedule or what it holds as a mapping
    (docs/formats.md: Ageing). ``options`` are those of the command, with the same
    names, meaning and defaults: :func:`lifecycle_options` prints them.

    The files are written to the folder ``out``, from which an interrupted run of the
    same call resumes; without one they are kept in the result alone.
    ``progress("lives", fraction)`` and Ctrl-C act as in :func:`correct`.

    Raises InvalidInputError (a ValueError), and TypeError for an unknown option.
    """
    texts = option_texts("lifecycle", _mle._lifecycle_options(), options)
    text, _, _, shown = text_and_source(ageing, "ageing")
    arguments = ["model", shown] + ([] if plant is None else ["plant"])
    call = ", ".join(arguments + [f"{name}={value!r}" for name, value in options.items()])
    files = _mle._lifecycle(
        given_model(model),
        text,
        given_model(plant),
        "" if out is None else os.fspath(out),
        texts,
        f"mle.lifecycle({call})",
        progress,
    )
    return LifecycleResult(files)


def lifecycle_options() -> str:
    """The options of :func:`lifecycle`: names, defaults, units, ranges and meaning."""
    return help_on(_mle._lifecycle_options())
