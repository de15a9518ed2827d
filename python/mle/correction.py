"""Corrections of process models from records."""

from __future__ import annotations

import base64
import html
import json
import os
from typing import TYPE_CHECKING, Any, Callable, Dict, List, NamedTuple, Optional, Union

from . import _mle
from ._mle import ProcessModel, StateSpaceModel, StepResponseModel
from .model import KINDS, ModelLike, given_model, read_model
from .next_move import NextMove
from .options import help_on, option_texts, takes_keywords
from .records import source_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import CorrectOptions

Progress = Callable[[str, float], Optional[bool]]


class Message(NamedTuple):
    """A finding in words: ``text`` is a whole sentence about ``place`` (empty: the
    whole run), ``code`` tells its kind, ``options`` what would change it."""

    code: str
    place: str
    text: str
    options: List[str]

    def __str__(self) -> str:
        return self.text


class StepResponse(NamedTuple):
    """Responses of the p outputs to unit steps of the m inputs at time 0.

    ``time`` is (N,), in the model's unit; the others are (N, p, m). ``lower`` and
    ``upper`` enclose the corrected response with the level ``confidence``, time by
    time; they are None where there is no process model behind it
    (``estimator="arx"``), and NaN or infinite where the records do not determine
    it.
    """

    time: Any
    initial: Any
    corrected: Any
    lower: Any
    upper: Any


def _messages(parts: Any) -> List[Message]:
    return [Message(*part) for part in parts]


class CorrectionResult:
    """What :func:`correct` found out.

    ``decision`` is "corrected", "no_change" or "cannot_tell"; ``corrected`` is the
    model for use, ``initial`` unless the decision is "corrected". ``print()`` shows
    what to do and why, :meth:`summary` what that rests on; in a notebook the result
    shows itself. :meth:`report` writes the whole page.
    """

    _ATTRIBUTES = (
        "initial _short _details _json _files _as_given _responses reasons notes warnings failures "
        "usable"
    ).split()

    initial: ProcessModel
    reasons: List[Message]
    notes: List[Message]
    warnings: List[Message]
    failures: List[Message]
    usable: bool

    def __init__(self, correction: Any) -> None:
        self._correction = correction
        self._page: Optional[str] = None
        self._pictures: Optional[List[str]] = None
        self._short = correction.short_verdict()
        self._details = correction.details()
        self.initial = correction.initial
        self._json = correction.json()
        self._files = correction.model_files()
        self._as_given = correction.corrected_as_given()
        self._responses = StepResponse(*correction.responses())
        self.reasons = _messages(correction.reasons)
        self.notes = _messages(correction.notes)
        self.warnings = _messages(correction.warnings)
        self.failures = _messages(correction.failures)
        self.usable = correction.usable
        self._parsed: Optional[Dict[str, Any]] = None

    def to_json(self) -> str:
        """The text of result.json, as the command writes it (docs/formats.md)."""
        return self._json

    def to_dict(self) -> Dict[str, Any]:
        """result.json as Python's objects."""
        if self._parsed is None:
            self._parsed = json.loads(self._json)
        return self._parsed

    @property
    def decision(self) -> str:
        return self.to_dict()["decision"]

    @property
    def verdict(self) -> List[str]:
        """What to do and why, in sentences."""
        return self.to_dict()["verdict"]

    @property
    def advice(self) -> List[str]:
        """What to do next, the most urgent first."""
        return self.to_dict()["advice"]

    @property
    def p_value(self) -> float:
        """Of the test that nothing has changed."""
        return self.to_dict()["test_of_no_change"]["p_value"]

    @property
    def corrected(self) -> Union[ProcessModel, StepResponseModel, StateSpaceModel]:
        """The model for use, of the kind given: step responses where the model given
        was such, with the coefficients of pairs that have not changed as they were; a
        state space where it was such, whose states are kept and followed by those of
        what has changed; else transfer functions of any order."""
        return self.process if self._as_given is None else self._as_given

    @property
    def process(self) -> ProcessModel:
        """The model for use as transfer functions of any order, whatever was given."""
        return ProcessModel.from_json(self._files["model.json"])

    @property
    def fopdt(self) -> ProcessModel:
        """The same by first-order elements with dead time."""
        return ProcessModel.from_json(self._files["fopdt.json"])

    @property
    def state_space(self) -> Optional[StateSpaceModel]:
        """The same in discrete state space; None where no such model of low order
        is near enough."""
        text = self._files.get("state_space.json")
        return None if text is None else StateSpaceModel.from_json(text)

    @property
    def step_response(self) -> StepResponse:
        """Responses of the initial and the corrected model, with the latter's band."""
        return self._responses

    @property
    def elements(self) -> Any:
        """A data frame with a row for each element, indexed by output and input.

        ``state``, ``information``, ``p_value`` (of no change) and ``aged``; of each
        of ``gain``, ``time_constant`` and ``delay`` the value ``*_initial``, the
        estimate ``*_estimate`` with its interval ``*_lower`` to ``*_upper``, and
        ``*_corrected``, which is NaN where nothing was corrected; and
        ``response_change``, how much of the step response changes.
        """
        import pandas as pd

        rows = [_row(element) for element in self.to_dict()["elements"]]
        return pd.DataFrame(rows).set_index(["output", "input"])

    @property
    def filters(self) -> Any:
        """A data frame with a row for each output, of the filters of its disturbance.

        ``bias_gain`` at the control period and ``bias_time_constant`` are those of a
        bias filter, ``gain_in_use`` that of the one in use; ``bias_error``,
        ``kalman_error`` and ``error_in_use`` are the errors of predictions, and
        ``bias_better`` and ``kalman_better`` say whether the filter in use is worse;
        ``missing`` is why an output has no filter, or empty. The Kalman gain is in
        ``state_space.disturbance_model``. Without rows where nothing was estimated.
        """
        import pandas as pd

        rows = [_filter_row(row) for row in self.to_dict().get("filter", [])]
        return pd.DataFrame(rows, columns=_FILTER_COLUMNS).set_index("output")

    @property
    def plan(self) -> Optional[NextMove]:
        """The next move, where ``plan=True`` asked for it; else None."""
        plan = self.to_dict().get("plan")
        return None if plan is None else NextMove(plan)

    def summary(self) -> str:
        """What the command prints with --verbose: verdict, what it rests on, tables of
        elements, validation and residuals, and what to do."""
        return f"{self._short}\n\n{self._details}"

    def plot(self, axes: Any = None) -> Any:
        """Draws the step responses of the initial and the corrected model by matplotlib:
        an axis for each output and input. Returns the figure."""
        from .plots import draw_responses

        return draw_responses(self, axes)

    def report_html(self) -> str:
        """The text of the page report.html, with its figures."""
        if self._page is None:
            self._page = self._correction.page()
        return self._page

    def report(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the page that the command writes to ``path``."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.report_html())

    def write(self, folder: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the files of the command to ``folder``: result.json, report.html,
        model.json, model.mat, model_corrected (in the form of the model given), fopdt.json,
        state_space.json, arx.json and step_response.csv, those that the result has."""
        os.makedirs(folder, exist_ok=True)
        texts = {**self._files, "result.json": self._json, "report.html": self.report_html()}
        for name, text in texts.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(text if isinstance(text, bytes) else text.encode("utf-8"))

    def __getstate__(self) -> Dict[str, Any]:
        state = {name: getattr(self, name) for name in self._ATTRIBUTES}
        # They cannot be made afterwards.
        state["_page"] = self.report_html()
        state["_pictures"] = self._figures()
        return state

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._correction = None
        self._parsed = None

    def __repr__(self) -> str:
        return f"<mle.CorrectionResult '{self.initial.name}': {self.decision}>"

    def __str__(self) -> str:
        return self._short

    def _figures(self) -> List[str]:
        """The map of pairs and the responses that have changed, as SVG."""
        if self._pictures is None:
            self._pictures = self._correction.figures()
        return self._pictures

    def _repr_html_(self) -> str:
        first, *others = self._short.split("\n")
        sentences = "".join(f"<p>{html.escape(text)}</p>" for text in others)
        pictures = "".join(
            '<p><img style="max-width: 100%" src="data:image/svg+xml;base64,'
            f'{base64.b64encode(svg.encode()).decode()}"></p>'
            for svg in self._figures()
        )
        name = html.escape(f"{self.initial.name} ({self.decision}): {first}")
        return f"<p><b>{name}</b></p>{sentences}{pictures}"


_FILTER_COLUMNS = (
    "output gain_in_use error_in_use bias_gain bias_time_constant bias_error bias_better "
    "kalman_error kalman_better missing"
).split()


def _filter_row(row: Dict[str, Any]) -> Dict[str, Any]:
    nan = float("nan")
    bias, kalman = row.get("bias", {}), row.get("kalman", {})
    return {
        "output": row["output"],
        "gain_in_use": row["gain_in_use"],
        "error_in_use": row.get("error_in_use", nan),
        "bias_gain": bias.get("gain", nan),
        "bias_time_constant": bias.get("time_constant", nan),
        "bias_error": bias.get("error", nan),
        "bias_better": bias.get("better", False),
        "kalman_error": kalman.get("error", nan),
        "kalman_better": kalman.get("better", False),
        "missing": row.get("missing", ""),
    }


def _row(element: Dict[str, Any]) -> Dict[str, Any]:
    nan = float("nan")

    def number(value: Any) -> float:
        return nan if value is None else value

    row = {name: element[name] for name in ("output", "input", "state", "information")}
    row["p_value"] = number(element.get("p_value"))
    row["aged"] = element.get("aged", False)
    for name in ("gain", "time_constant", "delay"):
        parameter = element.get(name, {})
        estimate = parameter.get("all_free", {})
        row[name + "_initial"] = number(parameter.get("initial"))
        row[name + "_estimate"] = number(estimate.get("value"))
        row[name + "_lower"] = number(estimate.get("lower"))
        row[name + "_upper"] = number(estimate.get("upper"))
        row[name + "_corrected"] = number(parameter.get("corrected", {}).get("value"))
    row["response_change"] = number(element.get("response_change"))
    return row


def _call_text(model: Any, source: tuple, options: Dict[str, Any]) -> str:
    """The call, as it may be typed again."""
    shown = [repr(model) if isinstance(model, str) else "model"]
    kind, records = source
    if kind == "files":
        shown.append(repr(records[0]) if len(records) == 1 else repr(records))
    else:
        shown.append("records")
    shown += [f"{name}={value!r}" for name, value in options.items()]
    return f"mle.correct({', '.join(shown)})"


@takes_keywords(_mle._correct_options())
def correct(
    model: ModelLike,
    records: Any,
    *,
    truth: Optional[ModelLike] = None,
    progress: Optional[Progress] = None,
    **options: Unpack[CorrectOptions],
) -> CorrectionResult:
    """Corrects a process model from records of routine closed-loop operation with
    set-point changes, and says whether it has aged, where, by how much, and how far
    the correction can be trusted.

    ``model`` is the controller's: transfer functions, step responses or a state
    space, or the path of a model file of any form. ``records`` are paths of files
    that the command mle_correct reads, names of databases (``postgresql://…``,
    ``sqlite:FILE``, ``odbc:NAME``, with ``table`` or ``query``), data frames with a
    DatetimeIndex (or times as numbers in the model's unit) and a column for each
    input and output, by name, and each set point (``<output>_setpoint``), or
    :class:`Record`: one or a list. ``options`` are the command's, with the same names,
    meaning and defaults: :func:`correct_options` prints them. ``truth`` is the model
    of a simulated plant, to be compared with.

    ``progress(stage, fraction)`` is called on the calling thread; if it returns
    False, CancelledError is raised. Other threads of Python run meanwhile, and
    Ctrl-C stops the call within a second.

    Raises InvalidInputError (a ValueError) for what is wrong with model, records and
    options, NotUsableError where a fit behind the model for use failed, OSError for
    files, and TypeError for an unknown option.
    """
    texts = option_texts("correct", _mle._correct_options(), options)
    source = source_of(records, options)
    model = os.fspath(model) if isinstance(model, os.PathLike) else given_model(model)
    text = _call_text(model, source, dict(options))
    done = _mle._correct(model, source, texts, given_model(truth), text, progress)
    return CorrectionResult(done)


def correct_options() -> str:
    """The options of :func:`correct`: names, defaults, units, ranges and meaning."""
    return help_on(_mle._correct_options())


class Advice:
    """What :func:`advice` found out.

    ``elements`` is a data frame with a row for each element: ``state`` ("informed",
    "weak" or "not_informed") and the standard errors that a correction may expect,
    ``gain_error`` and ``time_constant_error`` relative, ``delay_error`` in the model's
    time unit; ``feedback`` says of each output whether inputs answer to it;
    ``obstacle`` is what forbids a correction, or empty; ``warnings`` and ``notes`` are
    lists of :class:`Message`. ``print()`` shows what the command prints with --dry_run.
    """

    def __init__(self, model: Any, parts: tuple) -> None:
        import pandas as pd

        names = "output input state gain_error time_constant_error delay_error".split()
        self._text, rows, feedback, self.obstacle, warnings, notes = parts
        self.elements = pd.DataFrame(rows, columns=names).set_index(names[:2])
        self.feedback = dict(zip(model.outputs, feedback))
        self.warnings = _messages(warnings)
        self.notes = _messages(notes)

    def __str__(self) -> str:
        return "\n".join([self._text, *(f"warning: {one}" for one in self.warnings)])

    def __repr__(self) -> str:
        return f"<mle.Advice on {len(self.elements)} elements>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


@takes_keywords(_mle._correct_options())
def advice(records: Any, model: ModelLike, **options: Unpack[CorrectOptions]) -> Advice:
    """What records can tell of a model, before anything is corrected: channels, windows,
    how well each element could be estimated, feedback and doubts.

    The arguments are those of :func:`correct`, the records first.
    """
    if isinstance(records, KINDS):
        raise TypeError("advice(): the records come first, then the model")
    texts = option_texts("advice", _mle._correct_options(), options)
    model = given_model(model)
    return Advice(read_model(model), _mle._advice(model, source_of(records, options), texts))
