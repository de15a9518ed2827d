"""Simulation of a plant under a controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Optional

from . import _mle
from ._mle import Record
from .model import ModelLike, given_model
from .options import help_on, option_texts, takes_keywords

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import SimulateOptions


@takes_keywords(_mle._simulate_options())
def simulate(
    model: ModelLike,
    plant: Optional[ModelLike] = None,
    *,
    controller: Optional[Callable[[Any, Any, Any], Any]] = None,
    **options: Unpack[SimulateOptions],
) -> Record:
    """The record that a historian would have of a plant under predictive control.

    ``model`` is what the controller believes, ``plant`` what is true: a model with
    the same channels, each an object or the path of a file, or as plant the name of
    a non-linear one, as "van_de_vusse"; None: ``model`` itself. ``options`` are
    those of the command mle_simulate, with the same names, meaning and defaults
    (:func:`simulate_options` prints them), as
    ``setpoints=[("overhead", 300, 1)]``, ``duration``, ``sample_time``, ``seed`` and
    those of :class:`Mpc`.

    ``controller(measured, set_points, last_inputs)`` replaces the predictive
    controller: at each control instant it is given arrays (p,), (p,) and (m,) and
    returns the inputs (m,) that act from the next instant on.

    Raises InvalidInputError, and NotUsableError where the loop diverges.
    """
    texts = option_texts("simulate", _mle._simulate_options(), options)
    model, plant = given_model(model), given_model(plant)
    if controller is None:
        return _mle._simulate(model, plant, texts)
    return _mle._simulate_with(model, plant, texts, controller)


def simulate_options() -> str:
    """The options of :func:`simulate`: names, defaults, units, ranges and meaning."""
    return help_on(_mle._simulate_options())
