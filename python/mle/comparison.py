"""How well models describe records: predictions, fits and residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple

from . import _mle
from ._mle import Record
from .model import ModelLike, given_model, read_model
from .options import takes_keywords
from .records import imported, pandas_unit, times_of, to_dataframe

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import ReadOptions


def _parts(records: Any, frames: List[Any]) -> Any:
    """A frame for each of several :class:`Record`; else one, in order of time."""
    import pandas as pd

    if not isinstance(records, (str, Record)) and isinstance(records, Sequence):
        if all(isinstance(one, Record) for one in records):
            return frames
    return pd.concat(frames)


def _predicted(
    records: Any, model: ModelLike, horizon: Optional[int], options: Dict[str, Any], function: str
) -> Tuple[List[Any], List[Any]]:
    """Data frames of the outputs, measured and predicted, of each record."""
    import pandas as pd

    read, start = imported(records, model, options, function)
    arrays = _mle._predict(given_model(model), read, 0 if horizon is None else horizon)
    model = read_model(model)
    measured = [to_dataframe(record, model, start)[model.outputs] for record in read]
    frames = [
        pd.DataFrame(array, times_of(record, model, start), model.outputs)
        for record, array in zip(read, arrays)
    ]
    return measured, frames


@takes_keywords(_mle._read_options())
def predict(
    records: Any,
    model: ModelLike,
    horizon: Optional[int] = 1,
    **options: Unpack[ReadOptions],
) -> Any:
    """What a model predicts of the outputs of records: a data frame with a column for
    each output (a list of them of a list of :class:`Record`).

    ``horizon`` h, in samples: from the outputs measured up to h samples before, with a
    level that is followed in noise, and from all inputs before; None: a simulation by
    the inputs alone, whose mean is that of the measured output. NaN where inputs or
    outputs are missing, and at the beginning, where it is not known what the inputs did
    before. ``options`` are those of :func:`read_records`.
    """
    return _parts(records, _predicted(records, model, horizon, dict(options), "predict")[1])


class Comparison:
    """What :func:`compare` found out.

    ``fits`` is a data frame: the fit of each output (rows) by each model (columns), 100
    for a perfect one and 0 for one that is no better than the mean,

        100 (1 - |y - prediction| / |y - mean of y|) %,

    over the samples that all models predict. ``measured`` holds data frames of the
    outputs, a frame for each record, and ``predicted`` the same of each model, by
    its name.
    """

    def __init__(
        self, measured: List[Any], predicted: Dict[str, List[Any]], horizon: Optional[int]
    ) -> None:
        self.measured = measured
        self.predicted = predicted
        self.horizon = horizon
        self.fits = _fits(measured, predicted)

    def plot(self, axes: Any = None) -> Any:
        """Draws the outputs, measured and predicted, by matplotlib: an axis for each.
        Returns the figure."""
        from .plots import draw_comparison

        return draw_comparison(self, axes)

    def __str__(self) -> str:
        how = "simulated" if self.horizon is None else f"predicted {self.horizon} samples ahead"
        return f"Fit (%), {how}\n{self.fits.round(1).to_string()}"

    def __repr__(self) -> str:
        return f"<mle.Comparison of {', '.join(self.predicted)}>"

    def _repr_html_(self) -> str:
        return self.fits.to_html(float_format="{:.1f}".format)


def _fits(measured: List[Any], predicted: Dict[str, List[Any]]) -> Any:
    import numpy as np
    import pandas as pd

    sums = {name: 0.0 for name in predicted}
    total: Any = 0.0
    for k, outputs in enumerate(measured):
        errors = {name: outputs - frames[k] for name, frames in predicted.items()}
        known = np.logical_and.reduce([error.notna() for error in errors.values()])
        outputs = outputs.where(known)
        total = total + ((outputs - outputs.mean()) ** 2).sum()
        for name, error in errors.items():
            sums[name] = sums[name] + (error.where(known) ** 2).sum()
    total = total.where(total > 0.0)
    return pd.DataFrame({name: 100 * (1 - np.sqrt(sum_ / total)) for name, sum_ in sums.items()})


def _names(models: Sequence[Any]) -> List[str]:
    names: List[str] = []
    for model in models:
        name = model.name
        same = sum(other.split(" (")[0] == name for other in names)
        names.append(f"{name} ({same + 1})" if same else name)
    return names


@takes_keywords(_mle._read_options())
def compare(
    records: Any, *models: ModelLike, horizon: Optional[int] = None, **options: Unpack[ReadOptions]
) -> Comparison:
    """How well models describe records: the fit of each output by each model.

    ``records`` are what :func:`correct` takes, or the ``TimeResponseData`` of
    python-control; their channels are those of each model, by name. ``horizon`` is that
    of :func:`predict`: None compares with a simulation, as is usual. ``options`` are
    those of :func:`read_records`. Correct a model with some records and compare with
    others: a fit to the same records says little.

        print(mle.compare(april, model, result.corrected))
    """
    if not models:
        raise TypeError("compare() needs records and at least one model")
    parts = [_predicted(records, model, horizon, dict(options), "compare") for model in models]
    names = _names([read_model(model) for model in models])
    measured = parts[0][0]
    predicted = {
        name: [frame[measured[0].columns] for frame in frames]
        for name, (_, frames) in zip(names, parts)
    }
    return Comparison(measured, predicted, horizon)


class Residuals:
    """What :func:`resid` found out, of the errors of predictions one sample ahead.

    ``autocorrelation`` (a column for each output) and ``cross_correlation`` with the
    inputs (a column for each output and input; at lags above 0 the error is later) are
    data frames over the lag in samples; ``autocorrelation_limits`` and
    ``cross_correlation_limits`` are what white errors exceed once in a hundred lags.
    ``p_values`` has a row for each output: that its errors are ``white``, and do not
    depend on each input; below 0.01 the model, or that of the noise, lacks something.
    Correlations at lags of 0 and below are the answers of a controller.
    """

    def __init__(self, parts: List[tuple], outputs: List[str], inputs: List[str]) -> None:
        import pandas as pd

        pairs = pd.MultiIndex.from_product([outputs, inputs], names=["output", "input"])
        every = [one for part in parts for one in part[4]]
        self.autocorrelation = pd.DataFrame(
            {name: part[1] for name, part in zip(outputs, parts)},
            pd.Index(parts[0][0].astype(int), name="lag"),
        )
        self.cross_correlation = pd.DataFrame(
            [one[1] for one in every], pairs, pd.Index(every[0][0].astype(int), name="lag")
        ).T
        self.autocorrelation_limits = pd.Series([part[2] for part in parts], outputs)
        self.cross_correlation_limits = pd.Series([one[2] for one in every], pairs)
        self.p_values = pd.DataFrame(
            [[part[3], *(one[3] for one in part[4])] for part in parts],
            outputs,
            ["white", *inputs],
        )

    def plot(self, axes: Any = None) -> Any:
        """Draws the correlations by matplotlib: a row for each output, a column for
        itself and each input. Returns the figure."""
        from .plots import draw_residuals

        return draw_residuals(self, axes)

    def __repr__(self) -> str:
        return f"<mle.Residuals of {', '.join(self.p_values.index)}>"

    def __str__(self) -> str:
        shown = self.p_values.to_string(float_format="{:.2g}".format)
        return f"p-values of white residuals, and of none that depend on an input\n{shown}"

    def _repr_html_(self) -> str:
        return self.p_values.to_html(float_format="{:.2g}".format)


@takes_keywords(_mle._read_options())
def resid(
    records: Any, model: ModelLike, max_lag: Optional[int] = None, **options: Unpack[ReadOptions]
) -> Residuals:
    """Whether a model leaves anything of records that can be predicted: correlations of
    its errors with themselves and with the inputs.

    ``max_lag``, in samples, is by default as long as the model's inputs act. The other
    arguments are those of :func:`compare`.
    """
    if max_lag is not None and max_lag < 1:
        raise ValueError(f"max_lag = {max_lag}: it must be at least 1")
    read, _ = imported(records, model, options, "resid")
    parts = _mle._residuals(given_model(model), read, max_lag or 0)
    model = read_model(model)
    return Residuals(parts, model.outputs, model.inputs)


def _steps(times: Any, model: Any) -> float:
    """The sample time of evenly spaced times or dates, in the model's unit."""
    import numpy as np
    import pandas as pd

    times = pd.Index(times)
    if isinstance(times, pd.DatetimeIndex):
        times = (times - times[0]) / pd.Timedelta(1, pandas_unit(model))
    steps = np.diff(np.asarray(times, dtype=float))
    if len(steps) < 1 or steps[0] <= 0 or np.ptp(steps) > 1e-6 * steps[0]:
        raise ValueError("T: times must be at least two, increasing and evenly spaced")
    return float(steps.mean())


def lsim(model: ModelLike, U: Any, T: Any = None) -> Any:
    """The response of a model to inputs, from rest at zero.

    ``U`` is a data frame with a column for each input, by name, whose index are times or
    dates; then a data frame of the outputs is returned. Or it is an array (N, m), of one
    input also (N,), with times ``T`` (N,) or their interval, in the model's unit; then
    an array (N, p). Inputs act from their sample to the next (zero-order hold).
    :func:`simulate` simulates a plant with its controller.
    """
    import numpy as np

    given, model = given_model(model), read_model(model)
    frame = hasattr(U, "columns")
    if frame:
        missing = [name for name in model.inputs if name not in U.columns]
        if missing:
            raise ValueError(f"U has no column {', '.join(map(repr, missing))}")
        samples = U[model.inputs].to_numpy(dtype=float)
        T = U.index
    else:
        samples = np.asarray(U, dtype=float)
        samples = samples[:, None] if samples.ndim == 1 else samples
        if T is None:
            raise TypeError("lsim() needs T, the times of an array U or their interval")
    step = float(T) if np.ndim(T) == 0 else _steps(T, model)
    outputs = _mle._lsim(given, samples, step)
    if not frame:
        return outputs
    import pandas as pd

    return pd.DataFrame(outputs, U.index, model.outputs)
