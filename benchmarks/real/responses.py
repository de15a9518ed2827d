"""Exact responses of process models to held inputs, and the errors by which models are judged.

An input holds its value from one sample to the next. The response to it is then

    y(n) = Σ_j (s(j) − s(j − 1)) (u(n − j) − u(0))

with the step response s of the element at whole samples, whatever its dead time. Outputs start at
rest: what a model says of them is compared after the mean of the error, or its value where a
prediction starts, is removed.
"""

import math

import numpy as np


def polynomials(element):
    """Numerator and denominator in s, highest power first, without leading zeros."""
    if "gain" in element:
        numerator, denominator = [element["gain"]], [element.get("time_constant", 0.0), 1.0]
        if element.get("integrating"):
            denominator.append(0.0)
    else:
        numerator, denominator = list(element["numerator"]), list(element["denominator"])
    for coefficients in (numerator, denominator):
        while len(coefficients) > 1 and coefficients[0] == 0.0:
            del coefficients[0]
    return numerator, denominator


def exponential(matrix):
    """e to a small matrix: Taylor, scaled and squared."""
    squarings = max(0, math.ceil(math.log2(max(np.abs(matrix).sum(axis=1).max(), 1e-300))) + 3)
    scaled = matrix / 2.0**squarings
    result = term = np.eye(len(matrix))
    for k in range(1, 20):
        term = term @ scaled / k
        result = result + term
    for _ in range(squarings):
        result = result @ result
    return result


def step_response(element, interval, samples):
    """The response at 0, interval, … to a unit step at 0."""
    numerator, denominator = polynomials(element)
    times = interval * np.arange(samples) - element["delay"]
    begun = times >= -1e-9 * interval
    times = np.maximum(times, 0.0)
    if len(denominator) == 1:
        return np.where(begun, numerator[0] / denominator[0], 0.0)
    if len(denominator) == 2 and len(numerator) == 1 and denominator[1] != 0.0:
        rise = -np.expm1(-times * denominator[1] / denominator[0])
        return np.where(begun, numerator[0] / denominator[1] * rise, 0.0)
    return np.where(begun, rational_step(numerator, denominator, times, interval), 0.0)


def rational_step(numerator, denominator, times, interval):
    """By the controllable form with its input as one more state."""
    order = len(denominator) - 1
    tail = np.array(denominator[1:]) / denominator[0]
    ahead = np.zeros(order + 1)
    ahead[order + 1 - len(numerator):] = np.array(numerator) / denominator[0]
    rates = np.zeros((order + 1, order + 1))
    rates[0, :order], rates[0, order] = -tail, 1.0
    rates[1:order, :order - 1] = np.eye(order - 1)
    read = np.append(ahead[1:] - ahead[0] * tail, ahead[0])
    result = np.zeros(len(times))
    first = int(np.argmax(times > 0.0)) if np.any(times > 0.0) else len(times)
    state = np.append(np.zeros(order), 1.0)
    result[:first] = read @ state  # where the step is, at a dead time of whole samples
    if first < len(times):
        state = exponential(rates * times[first]) @ state
        forward = exponential(rates * interval)
        for k in range(first, len(times)):
            result[k] = read @ state
            state = forward @ state
    return result


def simulate(elements, stretch):
    """The outputs that the elements make of the inputs of an evenly sampled stretch of record."""
    samples = len(stretch.time)
    size = 1 << (2 * samples - 1).bit_length()
    result = {}
    for element in elements:
        response = step_response(element, stretch.interval, samples)
        weights = np.diff(response, prepend=0.0)
        values = stretch.columns[element["input"]]
        made = np.fft.irfft(np.fft.rfft(weights, size) *
                            stretch.spectrum(element["input"], values, size), size)[:samples]
        result[element["output"]] = result.get(element["output"], 0.0) + made
    return result


def errors_of(elements, stretch, output):
    """Measured less simulated."""
    of_output = [element for element in elements if element["output"] == output]
    return stretch.columns[output] - simulate(of_output, stretch).get(output, 0.0)


def changes(errors, steps):
    """Errors of predictions so many samples ahead that start at what is measured."""
    moves = errors[steps:] - errors[:-steps]
    return moves[np.isfinite(moves)]


def root_mean_square(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan


def fit(errors, measured):
    """100 (1 − ‖e − ē‖ / ‖y − ȳ‖)."""
    known = np.isfinite(errors)
    if not np.any(known):
        return math.nan
    return 100.0 * (1.0 - float(np.std(errors[known]) / max(np.std(measured[known]), 1e-300)))


def typical_time(element):
    """Time constants and dead time together."""
    _, denominator = polynomials(element)
    if denominator[-1] == 0.0:  # integrates
        lag = denominator[-3] / denominator[-2] if len(denominator) > 2 else 0.0
    else:
        lag = denominator[-2] / denominator[-1] if len(denominator) > 1 else 0.0
    return lag + element["delay"]


def size_at_rest(element):
    """How far a unit step takes the output in five times that time."""
    span = max(5.0 * typical_time(element), 1e-9)
    return abs(float(step_response(element, span / 50.0, 51)[-1]))
