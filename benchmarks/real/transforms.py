"""Transforms of a model's channels (mle/model/transform.h): z = a + (f(x) - f(a)) / f'(a).

A model's elements are linear between what their inputs and outputs are transformed to.
"""

import math

import numpy as np

import records
import responses


def closed_form(transform):
    """z of x and x of z, slope 1 at a."""
    kind, a = transform["kind"], transform["at"]
    if kind in ("exponential", "equal_percentage"):
        c = transform["curvature"] if kind == "exponential" else \
            math.log(transform["rangeability"]) / (transform["open"] - transform["closed"])
        return (lambda x: a + np.expm1(c * (x - a)) / c, lambda z: a + np.log1p(c * (z - a)) / c)
    if kind in ("log", "power", "quick_opening"):
        d = a - (transform["closed"] if kind == "quick_opening" else transform.get("zero", 0.0))
        if kind == "log":
            return (lambda x: a + d * np.log1p((x - a) / d),
                    lambda z: a + d * np.expm1((z - a) / d))
        n = 0.5 if kind == "quick_opening" else transform["exponent"]
        return (lambda x: a + d / n * ((1.0 + (x - a) / d)**n - 1.0),
                lambda z: a + d * ((1.0 + n * (z - a) / d)**(1.0 / n) - 1.0))
    c = transform["curvature"]
    there, back = (np.sinh, np.arcsinh) if kind == "sinh" else (np.arctanh, np.tanh)
    if c < 0.0:
        there, back = back, there
    return (lambda x: a + there(c * (x - a)) / c, lambda z: a + back(c * (z - a)) / c)


def through(points, at):
    """Piecewise linear, straight on beyond the ends, slope 1 at `at`."""
    x, f = np.array(points, dtype=float).T
    slopes = np.diff(f) / np.diff(x)

    def line(knots, values, rates, where):
        segment = np.clip(np.searchsorted(knots, where, side="right") - 1, 0, len(rates) - 1)
        return values[segment] + rates[segment] * (where - knots[segment])

    level = line(x, f, slopes, at)
    slope = slopes[np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(slopes) - 1)]
    return (lambda value: at + (line(x, f, slopes, value) - level) / slope,
            lambda z: line(f, x, 1.0 / slopes, level + slope * (z - at)))


def of(channel):
    """z of x and x of z; None where the channel has no transform."""
    transform = channel.get("transform")
    if transform is None:
        return None
    if transform["kind"] == "piecewise_linear":
        return through(transform["points"], transform["at"])
    return closed_form(transform)


def errors_of(model, stretch, output):
    """Measured less simulated, in the output's own unit; of a transformed output the level of the
    simulation is that of what was measured."""
    columns, back = dict(stretch.columns), None
    for channel in (*model["inputs"], *model["outputs"]):
        name, curve = channel["name"], of(channel)
        if curve is None:
            continue
        columns[name] = curve[0](columns[name])
        if name == output:
            back = curve[1]
    errors = responses.errors_of(
        model["elements"], records.Stretch(stretch.interval, stretch.time, columns), output)
    if back is None:
        return errors
    return stretch.columns[output] - back(columns[output] - errors + np.nanmean(errors))
