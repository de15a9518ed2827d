"""Models of scipy.signal and python-control in and out.

Neither package is needed to import this one: what comes in is known by its
attributes (``num`` and ``den``, as of ``scipy.signal.TransferFunction`` and
``control.TransferFunction``), what goes out is made where the package is
installed.
"""

from __future__ import annotations

from typing import Any, Sequence

from . import model as _model
from ._mle import ProcessModel


def _is_scalar_system(system: Any) -> bool:
    import numpy as np

    return np.ndim(system.num[0]) == 0 if len(system.num) else True


def _check_continuous(system: Any) -> None:
    dt = getattr(system, "dt", None)
    if dt not in (None, 0):
        raise ValueError(
            f"the system is discrete (dt = {dt}); process models are continuous in time"
        )


def from_systems(systems: Any, delays: Any = 0.0, **names: Any) -> ProcessModel:
    """A process model of transfer functions of another package.

    ``systems`` is one system with ``num`` and ``den``: of one input and output
    (``scipy.signal.TransferFunction``, or what ``scipy.signal.StateSpace.to_tf()``
    gives) or of several (``control.TransferFunction``, whose ``num[i][j]`` are
    coefficients); or a table of such, ``systems[i][j]`` for output i and input j,
    where None or 0 stands for no effect. They are continuous in time; dead times,
    which these packages do not know, are ``delays`` (p, m) or one number. Other
    arguments as of :func:`from_fopdt`. Raises ValueError.
    """
    if hasattr(systems, "num"):
        _check_continuous(systems)
        if _is_scalar_system(systems):
            numerators, denominators = [[systems.num]], [[systems.den]]
        else:
            numerators, denominators = systems.num, systems.den
        for ours, theirs in (("inputs", "input_labels"), ("outputs", "output_labels")):
            if ours not in names and getattr(systems, theirs, None):
                names[ours] = list(getattr(systems, theirs))
        return _model.from_transfer_functions(numerators, denominators, delays, **names)
    numerators, denominators = [], []
    for row in systems:
        numerators.append([])
        denominators.append([])
        for system in row:
            if system is None or isinstance(system, (int, float)):
                numerators[-1].append([float(system or 0.0)])
                denominators[-1].append([1.0])
                continue
            if not hasattr(system, "num") and hasattr(system, "to_tf"):
                system = system.to_tf()
            _check_continuous(system)
            scalar = _is_scalar_system(system)
            numerators[-1].append(system.num if scalar else system.num[0][0])
            denominators[-1].append(system.den if scalar else system.den[0][0])
    return _model.from_transfer_functions(numerators, denominators, delays, **names)


def to_scipy(model: ProcessModel) -> Any:
    """(systems, delays): ``systems[i][j]`` is a
    ``scipy.signal.TransferFunction``, ``delays`` an array (p, m) of the dead
    times, which it does not hold."""
    import numpy as np
    from scipy import signal

    systems = []
    delays = np.zeros((len(model.outputs), len(model.inputs)))
    for i in range(len(model.outputs)):
        systems.append([])
        for j in range(len(model.inputs)):
            numerator, denominator, delays[i, j] = model.element(i, j)
            systems[-1].append(signal.TransferFunction(numerator, denominator))
    return systems, delays


def to_control(model: ProcessModel, pade_order: int = 0) -> Any:
    """A ``control.TransferFunction`` of the model. Dead times become Padé
    approximations of ``pade_order``; with 0 a model that has any raises
    ValueError, as that package does not know them."""
    import control
    import numpy as np

    numerators: Sequence = []
    denominators: Sequence = []
    for i in range(len(model.outputs)):
        numerators.append([])
        denominators.append([])
        for j in range(len(model.inputs)):
            numerator, denominator, delay = model.element(i, j)
            if delay > 0.0:
                if pade_order < 1:
                    raise ValueError("the model has dead times: choose a pade_order of 1 or more")
                num, den = control.pade(delay, pade_order)
                numerator = np.polymul(numerator, num)
                denominator = np.polymul(denominator, den)
            numerators[-1].append(np.asarray(numerator))
            denominators[-1].append(np.asarray(denominator))
    return control.TransferFunction(
        numerators,
        denominators,
        input_labels=list(model.inputs),
        output_labels=list(model.outputs),
    )
