"""A proposed model beside the one in use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

from . import _mle
from .model import ModelLike, given_model
from .options import takes_keywords
from .records import imported

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import ReadOptions


class Trial:
    """A trial of a model beside the one in use, on the records that come: whether to
    adopt it, to wait or to drop it, and after that whether to roll back.

    Evidence comes from the responses to changes of set points (docs/watch.md); it may be
    looked at after every record. ``level`` is the probability of ever adopting a model
    that is no better, of dropping one that is no worse, and of rolling back to one that
    is no better, each. ``sample_time`` is that of the records. Raises
    InvalidInputError."""

    def __init__(
        self,
        in_use: ModelLike,
        proposed: ModelLike,
        sample_time: float,
        level: float = 0.01,
    ) -> None:
        self._model = given_model(in_use)
        self._trial = _mle._Trial(self._model, given_model(proposed), sample_time, level)
        self._sample_time = sample_time

    def _read(self, records: Any, options: Dict[str, Any], function: str) -> Any:
        if not isinstance(records, _mle.Record):
            options = {"sample_time": self._sample_time, **options}
        return imported(records, self._model, options, function)[0]

    @takes_keywords(_mle._read_options())
    def learn(self, records: Any, **options: Unpack[ReadOptions]) -> None:
        """Operation before the trial, as that of the correction: how the loop answers
        set points, and how large the noise is. ``records`` and ``options`` are those of
        :func:`read_records`."""
        for record in self._read(records, options, "learn"):
            self._trial.learn(record)

    @takes_keywords(_mle._read_options())
    def look(self, records: Any, **options: Unpack[ReadOptions]) -> str:
        """Operation in the trial, in order of time: returns :attr:`advice`. The first
        settling time of each record is used up by what inputs did before it."""
        for record in self._read(records, options, "look"):
            self._trial.look(record)
        return self.advice

    def adopt(self) -> None:
        """The proposed model is in use from here on."""
        self._trial.adopt()

    @property
    def advice(self) -> str:
        """``"wait"``, ``"adopt"`` or ``"drop"``; once adopted ``"keep"`` or
        ``"roll_back"``."""
        return self._trial.verdict["advice"]

    @property
    def changes(self) -> int:
        """Changes of set points whose whole response was seen."""
        return self._trial.verdict["changes"]

    @property
    def left_share(self) -> float:
        """The share of what set points drive of the errors of the model in use that the
        proposed one leaves."""
        return self._trial.verdict["left_share"]

    @property
    def loss_ratio(self) -> float:
        """Errors several steps ahead on all records, proposed over in use. Controllers
        that answer disturbances are part of it: no advice rests on it."""
        return self._trial.verdict["loss_ratio"]

    @property
    def evidence(self) -> Any:
        """A data frame with the logarithms of the evidence after each response, ``for``
        the model that is not in use and ``against`` it. The advice changes at
        ln(1/level)."""
        import pandas as pd

        points = self._trial.verdict["evidence"]
        frame = pd.DataFrame(points, columns=["time", "for", "against"])
        return frame.set_index("time")
