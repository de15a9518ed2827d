"""Plain least squares of predictions several steps ahead, from the model given.

The gain and the time constants (in logarithms) and the dead time of every element are free. What
is minimised is the sum over three horizons of the squared errors of predictions, each divided by
that of the model given. There is no noise model, no prior, no test: levenberg-marquardt with the
parameters kept in a box.
"""

import math

import numpy as np

import plants  # of benchmarks/reality
import responses

FURTHEST = math.log(8.0)  # factor of a gain or a time constant
ITERATIONS = 60


def moved(element, parameters):
    log_gain, log_lag, delay = parameters
    return plants.aged(element, gain=math.exp(log_gain), time_constant=math.exp(log_lag),
                       delay=delay * responses.typical_time(element))


def minimise(residuals, start, lower, upper):
    """Levenberg–Marquardt with forward differences."""
    x, damping = start.copy(), 1e-3
    value = residuals(x)
    for _ in range(ITERATIONS):
        jacobian = np.empty((len(value), len(x)))
        for i in range(len(x)):
            step = 1e-4 if x[i] + 1e-4 <= upper[i] else -1e-4
            beside = x.copy()
            beside[i] += step
            jacobian[:, i] = (residuals(beside) - value) / step
        normal, slope = jacobian.T @ jacobian, jacobian.T @ value
        before = value @ value
        while damping < 1e8:
            scaled = normal + damping * np.diag(np.maximum(np.diag(normal), 1e-9))
            tried = np.clip(x - np.linalg.solve(scaled, slope), lower, upper)
            after = residuals(tried)
            if after @ after < before:
                break
            damping *= 4.0
        else:
            return x
        x, value, damping = tried, after, damping / 10.0
        if before - value @ value < 1e-7 * before:
            return x
    return x


def correct(model, stretches, horizons):
    """The model with every element fitted; horizons: time ahead, of each output."""
    result = dict(model, elements=[])
    for channel in model["outputs"]:
        output = channel["name"]
        elements = [element for element in model["elements"] if element["output"] == output]
        if elements:
            result["elements"] += fit_output(elements, stretches, output, horizons[output])
    return result


def fit_output(elements, stretches, output, horizons):
    def errors(some):
        return [responses.errors_of(some, stretch, output) for stretch in stretches]

    def ahead(of_stretches):
        return [np.concatenate([responses.changes(error, steps_ahead(stretch, horizon))
                                for error, stretch in zip(of_stretches, stretches)])
                for horizon in horizons]

    scales = [math.sqrt(max(float(moves @ moves), 1e-300))
              for moves in ahead(errors(elements))]

    def residuals(x):
        some = [moved(element, x[3 * i:3 * i + 3]) for i, element in enumerate(elements)]
        return np.concatenate([moves / scale for moves, scale
                               in zip(ahead(errors(some)), scales)])

    lower, upper = [], []
    for element in elements:
        lower += [-FURTHEST, -FURTHEST, -element["delay"] / responses.typical_time(element)]
        upper += [FURTHEST, FURTHEST, 2.0]
    x = minimise(residuals, np.zeros(3 * len(elements)), np.array(lower), np.array(upper))
    return [moved(element, x[3 * i:3 * i + 3]) for i, element in enumerate(elements)]


def steps_ahead(stretch, horizon):
    return max(1, round(horizon / stretch.interval))
