"""Examples to begin with. They are simulated: nothing is downloaded."""

from __future__ import annotations

from typing import Any, NamedTuple

from ._mle import ProcessModel
from .model import from_fopdt
from .records import to_dataframe
from .simulation import simulate


class Example(NamedTuple):
    """The controller's ``model``, a data frame of ``records`` of the aged plant, the
    ``plant`` itself, and what it is ``about``."""

    model: ProcessModel
    records: Any
    plant: ProcessModel
    about: str


def _column() -> Example:
    """The distillation column of Wood and Berry, the effects of steam halved."""
    names = {
        "inputs": ["reflux", "steam"],
        "outputs": ["overhead", "bottoms"],
        "input_units": ["lb/min", "lb/min"],
        "output_units": ["wt%", "wt%"],
    }
    gain, lag, delay = [[12.8, -18.9], [6.6, -19.4]], [[16.7, 21], [10.9, 14.4]], [[1, 3], [7, 3]]
    model = from_fopdt(gain, lag, delay, name="column", **names)
    plant = from_fopdt([[12.8, -9.45], [6.6, -9.7]], lag, delay, name="aged column", **names)
    record = simulate(
        model,
        plant,
        setpoints=[("overhead", 200, 1.0), ("bottoms", 500, 1.0)],
        duration=800,
        sample_time=1.0,
        noise_variance=1e-3,
        seed=1,
    )
    about = "A distillation column; steam has lost half of its effect."
    return Example(model, to_dataframe(record, model, "2024-03-04 06:00"), plant, about)


def _heaters() -> Example:
    """Two heaters and their temperatures, as on a bench; the second heater has aged."""
    names = {
        "inputs": ["Q1", "Q2"],
        "outputs": ["T1", "T2"],
        "input_units": ["%", "%"],
        "output_units": ["degC", "degC"],
        "time_unit": "s",
    }
    lag, delay = [[140, 190], [200, 150]], [[16, 35], [40, 15]]
    model = from_fopdt([[0.65, 0.25], [0.22, 0.6]], lag, delay, name="heaters", **names)
    plant = from_fopdt([[0.65, 0.17], [0.22, 0.4]], lag, delay, name="aged heaters", **names)
    record = simulate(
        model,
        plant,
        setpoints=[("T1", 600, 8.0), ("T2", 1800, 6.0), ("T1", 3000, -6.0), ("T2", 4200, -5.0)],
        duration=5400,
        sample_time=5.0,
        control_period=20,
        noise_variance=0.01,
        drift_variance=1e-5,
        seed=1,
    )
    about = "Two heaters that warm each other's sensors; the second has lost a third of its power."
    return Example(model, to_dataframe(record, model, "2024-03-04 06:00"), plant, about)


_EXAMPLES = {"column": _column, "heaters": _heaters}


def load_example(name: str = "column") -> Example:
    """An example: "column" (distillation) or "heaters" (on a bench), both of a plant that
    has aged. They are simulated when asked for, and the same each time.

        model, records, plant, about = mle.load_example("heaters")
        print(mle.correct(model, records))
    """
    if name not in _EXAMPLES:
        raise ValueError(f"there is no example {name!r}; there are {', '.join(sorted(_EXAMPLES))}")
    return _EXAMPLES[name]()
