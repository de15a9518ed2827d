"""The predictive controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

from . import _mle
from .model import ModelLike, given_model
from .options import option_texts, takes_keywords

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import MpcOptions


class Mpc:
    """A predictive controller, at rest in the beginning.

    ``options``, with the command's names and defaults: ``control_period`` (1, in the
    model's time unit), ``prediction_horizon`` (30) and ``control_horizon`` (5) in
    control periods, ``output_weight`` (0.2) and ``move_weight`` (0.1), a number or one
    for each channel, ``disturbance_variance_ratio`` (0.1), and the limits
    ``min_input``, ``max_input``, ``max_move``, ``min_output``, ``max_output`` and
    ``output_limit_cost``. Raises InvalidInputError.
    """

    @takes_keywords(_mle._mpc_options())
    def __init__(self, model: ModelLike, **options: Unpack[MpcOptions]) -> None:
        self._options: Dict[str, Any] = dict(options)
        self._mpc = _mle._Mpc(given_model(model), self._texts(self._options))

    @staticmethod
    def _texts(options: Dict[str, Any]) -> list:
        return option_texts("Mpc", _mle._mpc_options(), options)

    def step(self, measured: Any, set_points: Any) -> Any:
        """One control instant: of measured outputs (p,) and set points (p,) the inputs
        (m,) that act from the next instant on. What is not finite is taken as
        missing."""
        return self._mpc.step(measured, set_points)

    def step_with_preview(self, measured: Any, set_points: Any) -> Any:
        """The same with the set points of the next instants, (prediction_horizon, p)."""
        return self._mpc.step_with_preview(measured, set_points)

    def measure_disturbances(self, disturbances: Any) -> None:
        """What the inputs with the role of disturbances are from this instant on;
        before :meth:`step`."""
        self._mpc.measure_disturbances(disturbances)

    def restart(self, inputs: Any, outputs: Any) -> None:
        """Starts again as if inputs (m,) had stood for ever, and the outputs had come
        to rest at outputs (p,)."""
        self._mpc.restart(inputs, outputs)

    def exchange_model(self, model: ModelLike, **options: Unpack[MpcOptions]) -> None:
        """Continues with another model, and other options where given, without a
        bump. Raises InvalidInputError, and changes nothing, for other channels or
        another control period."""
        merged = {**self._options, **options}
        self._mpc.exchange(given_model(model), self._texts(merged))
        self._options = merged

    @property
    def predicted_outputs(self) -> Any:
        """(p,) at the coming instant."""
        return self._mpc.predicted_outputs

    @property
    def gain(self) -> Any:
        """Moves over stacked predicted errors, (inputs moved, p x horizon)."""
        return self._mpc.gain
