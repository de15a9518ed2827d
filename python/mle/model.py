"""Process models and step-response models from arrays."""

from __future__ import annotations

import json
import math
import os
from typing import Any, NamedTuple, Optional, Sequence, Union

from . import _mle
from ._mle import ProcessModel, StateSpaceModel, StepResponseModel

KINDS = (ProcessModel, StepResponseModel, StateSpaceModel)
# What functions take as a model: one of these, the path of a file, or a system of
# scipy.signal or python-control without dead times.
ModelLike = Union[ProcessModel, StepResponseModel, StateSpaceModel, str, "os.PathLike[str]", Any]


class DisturbanceModel(NamedTuple):
    """What disturbs the outputs beside the inputs, and the filter that follows it:

        d[k+1] = A d[k] + w[k],  y[k] = (the model's output) + C d[k] + v[k],
        e[k+1] = A e[k] + K (y[k] - (the model's output) - C e[k]),

    with the covariance Q of w and the variances R of v, at the model's sample
    time. ``K`` is the stationary Kalman gain, e the estimate of d. With n states
    and p outputs A is (n, n), C (p, n), K (n, p), Q (n, n) and R (p,); outputs
    whose rows of C are zero have no filter.
    """

    A: Any
    C: Any
    K: Any
    Q: Any
    R: Any


def given_model(model: ModelLike) -> Any:
    """What the compiled module takes: systems of other packages become models."""
    if isinstance(model, KINDS) or not hasattr(model, "dt"):
        return model
    from .interop import from_systems

    return from_systems(model)


def read_model(model: ModelLike) -> Union[ProcessModel, StepResponseModel, StateSpaceModel]:
    """The model itself, or that of a file or system."""
    model = given_model(model)
    return model if isinstance(model, KINDS) else _mle._process(model)


def numbers(values: Any, name: str) -> Any:
    """float64; raises ValueError, with ``name``, for what is masked or complex."""
    import numpy as np

    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked entries; a model needs all of its numbers")
    array = np.asarray(values)
    if np.iscomplexobj(array):
        raise ValueError(f"{name} is complex; it must be real")
    return np.asarray(array, dtype=float)


def _table(values: Any, name: str, outputs: int, inputs: int) -> list:
    """p x m numbers of a scalar, which stands for all elements, or an array."""
    import numpy as np

    array = numbers(values, name)
    if array.ndim == 0:
        array = np.full((outputs, inputs), float(array))
    if array.shape != (outputs, inputs):
        raise ValueError(
            f"{name} has the shape {array.shape}; it must be ({outputs}, {inputs}): "
            "outputs x inputs"
        )
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite; 0 stands for no gain")
    return array.tolist()


def _names(names: Optional[Sequence[str]], count: int, what: str) -> list:
    if names is None:
        return [f"{what}{k + 1}" for k in range(count)]
    if isinstance(names, str) or len(names) != count:
        raise ValueError(f"{what} names: {count} are needed, {names!r} is given")
    return list(names)


def _channels(names: Sequence[str], units: Optional[Sequence[str]], what: str) -> list:
    units = [""] * len(names) if units is None else _names(units, len(names), what + " unit")
    return [{"name": name, "unit": unit} for name, unit in zip(names, units)]


def _document(
    content, inputs, outputs, time_unit, name, input_units, output_units, disturbances
):
    """The text of a model's file: channels and `content`."""
    channels = _channels(inputs, input_units, "input")
    unknown = set(disturbances) - set(inputs)
    if unknown:
        raise ValueError(f"disturbances: {sorted(unknown)} are not inputs")
    for channel in channels:
        if channel["name"] in disturbances:
            channel["role"] = "disturbance"
    return json.dumps(
        {
            "name": name,
            "time_unit": time_unit,
            "inputs": channels,
            "outputs": _channels(outputs, output_units, "output"),
            **content,
        }
    )


def from_fopdt(
    gain: Any,
    time_constant: Any,
    delay: Any = 0.0,
    *,
    integrating: Any = False,
    inputs: Optional[Sequence[str]] = None,
    outputs: Optional[Sequence[str]] = None,
    time_unit: str = "min",
    name: str = "model",
    input_units: Optional[Sequence[str]] = None,
    output_units: Optional[Sequence[str]] = None,
    disturbances: Sequence[str] = (),
) -> ProcessModel:
    """A model of first-order elements with dead time, K e^(-L s) / (T s + 1).

    ``gain`` K is (p, m), outputs x inputs, 0 where an input does not reach an
    output; ``time_constant`` T > 0 and ``delay`` L >= 0 are (p, m) or one number
    for all, in ``time_unit`` (ms, s, min, h or d). Where ``integrating``, (p, m) or
    one for all, is true, the element is K e^(-L s) / (s (T s + 1)) with T >= 0: K is
    a slope, as of a level. Names are those of a data frame ``gain``, or y1, y2, ... and
    u1, u2, ..., unless given; ``disturbances`` are the names of inputs that are
    measured but not manipulated. Raises ValueError.
    """
    import numpy as np

    shape = np.shape(gain)
    if len(shape) != 2:
        raise ValueError(f"gain has the shape {shape}; it must be (outputs, inputs)")
    p, m = shape
    if hasattr(gain, "columns"):
        inputs = [str(name) for name in gain.columns] if inputs is None else inputs
        outputs = [str(name) for name in gain.index] if outputs is None else outputs
    inputs = _names(inputs, m, "u")
    outputs = _names(outputs, p, "y")
    integrates = _table(integrating, "integrating", p, m)
    gains = _table(gain, "gain", p, m)
    times = _table(time_constant, "time_constant", p, m)
    delays = _table(delay, "delay", p, m)
    elements = [
        {
            "output": outputs[i],
            "input": inputs[j],
            "gain": gains[i][j],
            "time_constant": times[i][j],
            "delay": delays[i][j],
            **({"integrating": True} if integrates[i][j] else {}),
        }
        for i in range(p)
        for j in range(m)
        if gains[i][j] != 0.0
    ]
    return ProcessModel.from_json(
        _document(
            {"elements": elements},
            inputs,
            outputs,
            time_unit,
            name,
            input_units,
            output_units,
            disturbances,
        ),
        "from_fopdt",
    )


def from_transfer_functions(
    numerators: Any,
    denominators: Any,
    delays: Any = 0.0,
    *,
    inputs: Optional[Sequence[str]] = None,
    outputs: Optional[Sequence[str]] = None,
    time_unit: str = "min",
    name: str = "model",
    input_units: Optional[Sequence[str]] = None,
    output_units: Optional[Sequence[str]] = None,
    disturbances: Sequence[str] = (),
) -> ProcessModel:
    """A model of transfer functions with dead times.

    ``numerators[i][j]`` and ``denominators[i][j]`` are the coefficients in s of
    element (i, j), highest power first: proper and stable. ``delays`` are (p, m)
    or one number for all, in ``time_unit``. Other arguments as of
    :func:`from_fopdt`. Raises ValueError.
    """
    numerators, denominators = _rows(numerators), _rows(denominators)
    p = len(numerators)
    m = len(numerators[0]) if p else 0
    for table, what in ((numerators, "numerators"), (denominators, "denominators")):
        if len(table) != p or any(len(row) != m for row in table):
            raise ValueError(f"{what} must have {p} rows of {m} lists of coefficients")
    inputs = _names(inputs, m, "u")
    outputs = _names(outputs, p, "y")
    dead_times = _table(delays, "delays", p, m)
    elements = []
    for i in range(p):
        for j in range(m):
            numerator = [float(b) for b in _coefficients(numerators[i][j])]
            denominator = [float(a) for a in _coefficients(denominators[i][j])]
            if not all(map(math.isfinite, numerator + denominator)):
                raise ValueError(f"element ({i}, {j}): coefficients must be finite")
            while len(numerator) > 1 and numerator[0] == 0.0:
                del numerator[0]
            if numerator == [0.0]:
                continue
            elements.append(
                {
                    "output": outputs[i],
                    "input": inputs[j],
                    "numerator": numerator,
                    "denominator": denominator,
                    "delay": dead_times[i][j],
                }
            )
    return ProcessModel.from_json(
        _document(
            {"elements": elements},
            inputs,
            outputs,
            time_unit,
            name,
            input_units,
            output_units,
            disturbances,
        ),
        "from_transfer_functions",
    )


def _rows(table: Any) -> list:
    return [list(row) for row in table]


def _coefficients(values: Any) -> list:
    import numpy as np

    return np.atleast_1d(numbers(values, "coefficients")).ravel().tolist()


def from_step_responses(
    coefficients: Any,
    dt: float,
    *,
    inputs: Optional[Sequence[str]] = None,
    outputs: Optional[Sequence[str]] = None,
    time_unit: str = "min",
    name: str = "model",
    input_units: Optional[Sequence[str]] = None,
    output_units: Optional[Sequence[str]] = None,
    disturbances: Sequence[str] = (),
) -> StepResponseModel:
    """A step-response (FIR) model of its coefficients.

    ``coefficients`` is (N, p, m): the responses of the outputs to unit steps of the
    inputs at 0, at ``dt``, 2 ``dt``, ..., N ``dt`` (in ``time_unit``), at least 10 of
    them; zeros where an input does not reach an output. Of impulse-response
    coefficients h it is ``h.cumsum(axis=0)``. Other arguments as of
    :func:`from_fopdt`. Raises ValueError, also where no transfer functions of low
    order describe it: where a response does not settle, for one.
    """
    import numpy as np

    array = numbers(coefficients, "coefficients")
    if array.ndim != 3:
        raise ValueError(
            f"coefficients has the shape {array.shape}; it must be (coefficients, outputs, inputs)"
        )
    if not np.isfinite(array).all():
        k, i, j = np.argwhere(~np.isfinite(array))[0]
        raise ValueError(f"coefficients[{k}, {i}, {j}] is {array[k, i, j]}; it must be finite")
    _, p, m = array.shape
    inputs = _names(inputs, m, "u")
    outputs = _names(outputs, p, "y")
    pairs = [
        {"output": outputs[i], "input": inputs[j], "coefficients": array[:, i, j].tolist()}
        for i in range(p)
        for j in range(m)
        if array[:, i, j].any()
    ]
    return StepResponseModel.from_json(
        _document(
            {"interval": float(dt), "step_responses": pairs},
            inputs,
            outputs,
            time_unit,
            name,
            input_units,
            output_units,
            disturbances,
        ),
        "from_step_responses",
    )
