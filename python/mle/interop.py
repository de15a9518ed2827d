"""Models of scipy.signal and python-control in and out.

Neither package is needed to import this one: what comes in is known by its
attributes (``num`` and ``den``, or ``A``, ``B``, ``C`` and ``D``, and ``dt``), what goes
out is made where the package is installed.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Dict, List, Sequence, Tuple

from . import model as _model
from ._mle import ProcessModel, StateSpaceModel, StepResponseModel
from .model import ModelLike

# Of poles and zeros: those nearer than this, relative to their size, cancel.
_CANCELS = 1e-7


def _is_state_space(system: Any) -> bool:
    return all(hasattr(system, name) for name in "ABCD")


def _is_scalar_system(system: Any) -> bool:
    import numpy as np

    return np.ndim(system.num[0]) == 0 if len(system.num) else True


def _sample_time(system: Any) -> float:
    """0 of a system in continuous time."""
    dt = getattr(system, "dt", None)
    if dt is True:
        raise ValueError("the system is discrete without a sample time (dt = True); give it one")
    return 0.0 if dt is None else float(dt)


def _labels(system: Any, names: Dict[str, Any]) -> Dict[str, Any]:
    """``names`` with those that the system has itself."""
    labels = {"inputs": "input_labels", "outputs": "output_labels"}
    found = {
        ours: list(getattr(system, theirs))
        for ours, theirs in labels.items()
        if getattr(system, theirs, None)
    }
    return {**found, **names}


def _without_common_roots(numerator: Any, denominator: Any) -> Tuple[Any, Any]:
    """The same ratio, without the poles that zeros cancel."""
    import numpy as np

    numerator = np.trim_zeros(numerator, "f")
    if not len(numerator):
        return np.zeros(1), np.ones(1)
    poles = list(np.roots(denominator))
    zeros = list(np.roots(numerator))
    for zero in list(zeros):
        near = min(poles, key=lambda pole: abs(pole - zero), default=None)
        if near is not None and abs(near - zero) <= _CANCELS * max(abs(near), abs(zero)):
            zeros.remove(zero)
            poles.remove(near)
    # Of a pair only one may have gone: not to be cancelled at all.
    left = numerator[0] * np.poly(zeros), denominator[0] * np.poly(poles)
    if len(poles) + 1 == len(denominator) or any(np.iscomplexobj(part) for part in left):
        return numerator, denominator
    return left


def _characteristic(matrix: Any) -> Any:
    """The coefficients of det(s I - matrix)."""
    import numpy as np

    coefficients = np.real(np.poly(matrix)) if np.isfinite(matrix).all() else matrix
    if not np.isfinite(coefficients).all():
        raise ValueError("A, B and C have coefficients of transfer functions beyond 1.8e308")
    return coefficients


def from_state_space(
    A: Any, B: Any, C: Any, D: Any = None, delays: Any = 0.0, **names: Any
) -> ProcessModel:
    """A process model of a state-space model in continuous time,

        dx/dt = A x + B u(t - L),  y = C x + D u(t - L).

    ``A`` is (n, n), ``B`` (n, m), ``C`` (p, n), ``D`` (p, m) or None for zeros;
    ``delays`` L (p, m) or one number. States that do not take part in an element
    cancel. Other arguments as of :func:`from_fopdt`. Raises ValueError. For models in
    discrete time there is :class:`StateSpaceModel`.
    """
    import numpy as np

    given = {"A": A, "B": B, "C": C}
    a, b, c = (np.atleast_2d(_model.numbers(matrix, name)) for name, matrix in given.items())
    n, m, p = len(a), b.shape[1], len(c)
    d = np.zeros((p, m)) if D is None else np.atleast_2d(_model.numbers(D, "D"))
    wanted = {"A": (a, (n, n)), "B": (b, (n, m)), "C": (c, (p, n)), "D": (d, (p, m))}
    for name, (matrix, shape) in wanted.items():
        if matrix.shape != shape:
            raise ValueError(f"{name} has the shape {matrix.shape}; it must be {shape}")
        if not np.isfinite(matrix).all():
            raise ValueError(f"{name} must be finite")
    denominator = _characteristic(a)
    numerators: List[list] = []
    denominators: List[list] = []
    for i in range(p):
        rows = []
        for j in range(m):
            # det(sI - A + b c) - det(sI - A) = c adj(sI - A) b.
            closed = _characteristic(a - np.outer(b[:, j], c[i]))
            numerator = closed + (d[i, j] - 1.0) * denominator
            scale = np.abs(closed) + np.abs(denominator)
            numerator[np.abs(numerator) <= 1e-13 * scale] = 0.0
            rows.append(_without_common_roots(numerator, denominator))
        numerators.append([row[0] for row in rows])
        denominators.append([row[1] for row in rows])
    return _model.from_transfer_functions(numerators, denominators, delays, **names)


def _discrete(system: Any, names: Dict[str, Any]) -> ProcessModel:
    import numpy as np

    unknown = set(names) - {"inputs", "outputs", "time_unit", "name"}
    if unknown:
        raise ValueError(f"{sorted(unknown)}: not for a system in discrete time")
    matrices = (np.atleast_2d(_model.numbers(getattr(system, x), x)) for x in "ABCD")
    return StateSpaceModel(*matrices, dt=_sample_time(system), **names).process


def _of_state_space(system: Any, delays: Any, names: Dict[str, Any]) -> ProcessModel:
    import numpy as np

    names = _labels(system, names)
    if _sample_time(system) == 0.0:
        return from_state_space(system.A, system.B, system.C, system.D, delays, **names)
    if np.any(np.asarray(delays)):
        raise ValueError("delays: in discrete time they are arguments of mle.StateSpaceModel")
    return _discrete(system, names)


def _is_transfer_function(system: Any) -> bool:
    return hasattr(system, "to_tf") or (hasattr(system, "num") and hasattr(system, "den"))


def _transfer_function(system: Any) -> Any:
    """With ``num`` and ``den``, in continuous time."""
    if not _is_transfer_function(system):
        raise TypeError(
            "a system must be a transfer function (num, den), zeros and poles (to_tf) or a state "
            f"space (A, B, C, D); this is {type(system).__name__}"
        )
    if not hasattr(system, "num"):
        system = system.to_tf()
    dt = _sample_time(system)
    if dt != 0.0:
        raise ValueError(
            f"the transfer function is discrete (dt = {dt}); convert it to state space "
            "(scipy.signal: to_ss(), control: control.ss()), which is taken as it is"
        )
    return system


def _entry(system: Any) -> Tuple[Any, Any, float]:
    """Numerator, denominator and dead time of one element of a table."""
    if system is None or isinstance(system, (int, float)):
        return [float(system or 0.0)], [1.0], 0.0
    if not _is_state_space(system):
        system = _transfer_function(system)
        if _is_scalar_system(system):
            return system.num, system.den, 0.0
    model = from_systems(system)
    if len(model.outputs) != 1 or len(model.inputs) != 1:
        raise ValueError(
            f"a system in a table must have one input and one output; this has "
            f"{len(model.inputs)} inputs and {len(model.outputs)} outputs"
        )
    return model.element(0, 0)


def from_systems(systems: Any, delays: Any = 0.0, **names: Any) -> ProcessModel:
    """A process model of systems of another package.

    ``systems`` is one system of scipy.signal or python-control: a transfer function
    (``num`` and ``den``), zeros and poles (``to_tf()``), or a state space (``A``, ``B``,
    ``C``, ``D``), of one input and output or of several; or a table of such of one
    input and output, ``systems[i][j]`` for output i and input j, where None or 0
    stands for no effect. Dead times, which these packages do not know, are ``delays``
    (p, m) or one number; those that a state space in discrete time has of its own come
    on top. A state space in discrete time (``dt``) becomes a
    :class:`StateSpaceModel`, whose ``process`` this is; discrete transfer functions
    are refused. Other arguments as of :func:`from_fopdt`. Raises ValueError.
    """
    if _is_state_space(systems):
        return _of_state_space(systems, delays, names)
    if _is_transfer_function(systems):
        systems = _transfer_function(systems)
        if _is_scalar_system(systems):
            numerators, denominators = [[systems.num]], [[systems.den]]
        else:
            numerators, denominators = systems.num, systems.den
        names = _labels(systems, names)
        return _model.from_transfer_functions(numerators, denominators, delays, **names)
    if not isinstance(systems, Iterable) or not all(isinstance(row, Iterable) for row in systems):
        raise TypeError(
            f"systems must be a system, or a table of such; this is {type(systems).__name__}"
        )
    entries = [[_entry(system) for system in row] for row in systems]
    if any(delay for row in entries for _, _, delay in row):
        # What discrete systems have of their own comes on top.
        given = _model._table(delays, "delays", len(entries), len(entries[0]))
        delays = [
            [more + own for more, (_, _, own) in zip(*rows)] for rows in zip(given, entries)
        ]
    return _model.from_transfer_functions(
        [[numerator for numerator, _, _ in row] for row in entries],
        [[denominator for _, denominator, _ in row] for row in entries],
        delays,
        **names,
    )


def _delay_states(model: StateSpaceModel) -> Tuple[Any, Any, Any, Any]:
    """A, B, C and D with a state for each sample of dead time."""
    import numpy as np

    a, b, c, d = model.A, model.B, model.C, model.D
    for j, delay in enumerate(model.input_delays):
        for _ in range(delay):
            # The state z[k+1] = u_j[k] in place of u_j.
            n = len(a)
            a = np.block([[a, b[:, [j]]], [np.zeros((1, n + 1))]])
            b = np.vstack([b, np.zeros((1, b.shape[1]))])
            c = np.hstack([c, d[:, [j]]])
            b[:n, j], d[:, j], b[n, j] = 0.0, 0.0, 1.0
    for i, delay in enumerate(model.output_delays):
        for _ in range(delay):
            # The state z[k+1] = w_i[k], and z in place of w_i.
            n = len(a)
            a = np.block([[a, np.zeros((n, 1))], [c[[i]], np.zeros((1, 1))]])
            b = np.vstack([b, d[[i]]])
            c = np.hstack([c, np.zeros((len(c), 1))])
            c[i], d[i], c[i, n] = 0.0, 0.0, 1.0
    return a, b, c, d


def _states_or_functions(model: Any) -> Any:
    """Of step responses the transfer functions that describe them."""
    model = _model.read_model(model)
    return model.process if isinstance(model, StepResponseModel) else model


def to_scipy(model: ModelLike) -> Any:
    """Of transfer functions (systems, delays): ``systems[i][j]`` is a
    ``scipy.signal.TransferFunction``, ``delays`` an array (p, m) of the dead times,
    which it does not hold. Of a StateSpaceModel a discrete
    ``scipy.signal.StateSpace``, dead times as states."""
    import numpy as np
    from scipy import signal

    model = _states_or_functions(model)
    if isinstance(model, StateSpaceModel):
        return signal.StateSpace(*_delay_states(model), dt=model.dt)
    systems: List[list] = []
    delays = np.zeros((len(model.outputs), len(model.inputs)))
    for i in range(len(model.outputs)):
        systems.append([])
        for j in range(len(model.inputs)):
            numerator, denominator, delays[i, j] = model.element(i, j)
            systems[-1].append(signal.TransferFunction(numerator, denominator))
    return systems, delays


def to_control(model: ModelLike, pade_order: int = 0) -> Any:
    """Of transfer functions a ``control.TransferFunction``. Dead times become Padé
    approximations of ``pade_order``; with 0 a model that has any raises ValueError, as
    that package does not know them. Of a StateSpaceModel a discrete
    ``control.StateSpace``, dead times as states. Needs python-control 0.9.2 or later."""
    import control
    import numpy as np

    model = _states_or_functions(model)
    names = {"inputs": list(model.inputs), "outputs": list(model.outputs)}
    if isinstance(model, StateSpaceModel):
        return control.StateSpace(*_delay_states(model), model.dt, **names)
    numerators: List[Sequence] = []
    denominators: List[Sequence] = []
    for i in range(len(model.outputs)):
        rows = []
        for j in range(len(model.inputs)):
            numerator, denominator, delay = model.element(i, j)
            if delay > 0.0:
                if pade_order < 1:
                    raise ValueError("the model has dead times: choose a pade_order of 1 or more")
                num, den = control.pade(delay, pade_order)
                numerator = list(np.polymul(numerator, num))
                denominator = list(np.polymul(denominator, den))
            rows.append((np.asarray(numerator), np.asarray(denominator)))
        numerators.append([row[0] for row in rows])
        denominators.append([row[1] for row in rows])
    return control.TransferFunction(numerators, denominators, **names)


def to_time_response(record: Any, model: ModelLike) -> Any:
    """A :class:`Record` as ``control.TimeResponseData``: its times, outputs and inputs. It
    goes back into all that takes records. Needs python-control 0.9.4 or later."""
    import control
    import numpy as np

    model = _model.read_model(model)
    return control.TimeResponseData(
        record.start_time + record.sample_time * np.arange(len(record)),
        record.outputs.T,
        None,
        record.inputs.T,
        output_labels=list(model.outputs),
        input_labels=list(model.inputs),
    )
