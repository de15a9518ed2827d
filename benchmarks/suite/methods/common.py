"""What the methods of this folder share: the record, simulation errors, how answers are left."""

import csv
import json
import math
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "benchmarks" / name) for name in ("real", "reality")]
import records  # noqa: E402
import responses  # noqa: E402
import runs  # noqa: E402


class Given:
    """model.json and record.csv of a folder."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.model = json.loads((self.folder / "model.json").read_text())
        self.inputs = [channel["name"] for channel in self.model["inputs"]]
        self.outputs = [channel["name"] for channel in self.model["outputs"]]
        with (self.folder / "record.csv").open(newline="", encoding="utf-8-sig") as file:
            header = next(csv.reader(file))
        # Set points hold their values as inputs do.
        self.set_points = [f"{name}_setpoint" for name in self.outputs
                           if f"{name}_setpoint" in header]
        held = self.model["inputs"] + [{"name": name} for name in self.set_points]
        self.stretches = [
            stretch for stretch in records.stretches(self.folder / "record.csv",
                                                     {**self.model, "inputs": held})
            if len(stretch.time) >= 10]
        self.interval = self.stretches[0].interval
        self.horizons = runs.horizons(self.model, self.stretches)

    def elements(self, output):
        return [element for element in self.model["elements"] if element["output"] == output]

    def settling(self):
        """In samples: five time constants and the dead time of the slowest element."""
        longest = max(5.0 * responses.typical_time(element) for element in self.model["elements"])
        return max(10, min(math.ceil(longest / self.interval),
                           max(len(stretch.time) for stretch in self.stretches) // 2))

    def errors(self, elements, output):
        """Measured less simulated, less its mean and, of a level, its slope, stretch by stretch;
        NaN where not measured."""
        ramp = any(element.get("integrating") for element in elements)
        return [centred(responses.errors_of(elements, stretch, output), ramp)
                for stretch in self.stretches]

    def leave(self, decision, elements=None, aged=(), intervals=()):
        if elements is not None:
            model = dict(self.model, elements=elements)
            (self.folder / "model.json").write_text(json.dumps(model, indent=1))
        with (self.folder / "decision.txt").open("w", newline="") as file:
            csv.writer(file).writerows(
                [[decision], *(["aged", *pair] for pair in aged),
                 *(["interval", *row] for row in intervals)])


def centred(values, ramp=False):
    known = np.isfinite(values)
    if not known.any():
        return values
    basis = np.vander(np.linspace(-1.0, 1.0, len(values)), 2 if ramp else 1)
    return values - basis @ np.linalg.lstsq(basis[known], values[known], rcond=None)[0]


def rows_of(values):
    """Finite values of all stretches."""
    joined = np.concatenate(values)
    return joined[np.isfinite(joined)]


def first_order(step, interval):
    """Gain, time constant and dead time of the nearest step response of first order, by least
    squares on a grid that is made finer three times."""
    times = interval * np.arange(len(step))
    lags = np.geomspace(0.5 * interval, times[-1], 30)
    delays = np.linspace(0.0, 0.6 * times[-1], 31)
    for _ in range(4):
        late = np.maximum(times - delays[:, None], 0.0)
        shapes = -np.expm1(-late[None, :, :] / lags[:, None, None])
        squares = np.maximum(np.einsum("ldt,ldt->ld", shapes, shapes), 1e-300)
        gains = shapes @ step / squares
        best = np.unravel_index(np.argmax(gains**2 * squares), gains.shape)
        found = float(gains[best]), float(lags[best[0]]), float(delays[best[1]])
        ratio = (lags[1] / lags[0])**1.5
        width = 1.5 * (delays[1] - delays[0])
        lags = np.geomspace(found[1] / ratio, found[1] * ratio, 13)
        delays = np.linspace(max(0.0, found[2] - width), found[2] + width, 13)
    gain, lag, delay = found
    return {"gain": gain if gain != 0.0 else 1e-12, "time_constant": lag, "delay": delay}


def of_steps(given, steps):
    """Elements of first order, of those pairs that the model has; steps by pair."""
    pairs = list(dict.fromkeys((element["output"], element["input"])
                               for element in given.model["elements"]))
    return [{"output": output, "input": source,
             **first_order(steps[output, source], given.interval)} for output, source in pairs]


def autoregression(values, order):
    """Coefficients a of e(t) = Σ a_k e(t − k) + w, by least squares over stretches."""
    rows, right = [], []
    for series in values:
        if len(series) <= 2 * order:
            continue
        lagged = np.column_stack([series[order - k:len(series) - k]
                                  for k in range(1, order + 1)])
        known = np.isfinite(lagged).all(axis=1) & np.isfinite(series[order:])
        rows.append(lagged[known])
        right.append(series[order:][known])
    rows, right = np.vstack(rows), np.concatenate(right)
    if len(right) < 4 * order:
        return np.zeros(order)
    return np.linalg.lstsq(rows, right, rcond=None)[0]


def filtered(series, coefficients):
    """w of the autoregression."""
    order = len(coefficients)
    if order == 0 or len(series) <= order:
        return series
    result = series[order:].copy()
    for k in range(1, order + 1):
        result -= coefficients[k - 1] * series[order - k:len(series) - k]
    return result


def chi_square_tail(value, degrees):
    """P(χ² > value), by Wilson and Hilferty's cube root."""
    if value <= 0.0:
        return 1.0
    spread = 2.0 / (9.0 * degrees)
    z = ((value / degrees)**(1.0 / 3.0) - 1.0 + spread) / math.sqrt(spread)
    return 0.5 * math.erfc(z / math.sqrt(2.0))


def normal_quantile(probability):
    """Upper quantile, by bisection."""
    low, high = 0.0, 40.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if 0.5 * math.erfc(middle / math.sqrt(2.0)) > probability:
            low = middle
        else:
            high = middle
    return low
