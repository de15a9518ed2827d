"""instruments.py FOLDER: instrumental variables made of set points.

For each output the gains, time constants and dead times θ of its elements minimise

    ε(θ)ᵀ Z (ZᵀZ)⁻¹ Zᵀ ε(θ),   ε = measured − simulated,

Z the changes of all set points since so many samples, up to the settling time, in at most 30 steps
each, and a constant (Söderström and Stoica, Instrumental Variable Methods for System
Identification, 1983; in closed loop: Gilson and Van den Hof, Automatica 41, 2005, 241). Loads, and
noise that the controller answers, are not correlated with the instruments. There is no test: it
always corrects.
"""

import math
import sys

import common
import least_squares  # of benchmarks/real
import numpy as np
import responses

STEPS = 30


def instruments(given, stretch):
    samples = len(stretch.time)
    settling = given.settling()
    hold = max(1, math.ceil(settling / STEPS))
    columns = []
    for name in given.set_points:
        values = stretch.columns[name] - stretch.columns[name][0]
        for lag in range(0, settling, hold):
            column = np.zeros(samples)
            column[lag:] = values[:samples - lag]
            columns.append(column)
    return np.column_stack(columns) if columns else np.zeros((samples, 0))


def basis(matrix):
    """Orthonormal, of what the columns span apart from a constant."""
    matrix = matrix - matrix.mean(axis=0)
    left, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    return left[:, sizes > 1e-6 * sizes[0]] if len(sizes) and sizes[0] > 0.0 else left[:, :0]


def fit(given, output, bases):
    elements = given.elements(output)
    ramp = any(element.get("integrating") for element in elements)

    def residuals(x):
        some = [least_squares.moved(element, x[3 * i:3 * i + 3])
                for i, element in enumerate(elements)]
        parts = []
        for stretch, (known, space) in zip(given.stretches, bases):
            error = common.centred(responses.errors_of(some, stretch, output), ramp)[known]
            parts.append(space.T @ error if len(error) else error)
        return np.concatenate(parts)

    start = residuals(np.zeros(3 * len(elements)))
    if len(start) == 0 or not start @ start > 0.0:
        return elements
    furthest = least_squares.FURTHEST
    lower, upper = [], []
    for element in elements:
        lower += [-furthest, -furthest, -element["delay"] / responses.typical_time(element)]
        upper += [furthest, furthest, 2.0]
    scale = math.sqrt(start @ start)
    x = least_squares.minimise(lambda point: residuals(point) / scale, np.zeros(len(lower)),
                               np.array(lower), np.array(upper))
    return [least_squares.moved(element, x[3 * i:3 * i + 3])
            for i, element in enumerate(elements)]


def main(folder):
    given = common.Given(folder)
    if not given.set_points:
        given.leave("cannot_tell")
        return
    lagged = [instruments(given, stretch) for stretch in given.stretches]
    elements = []
    for output in given.outputs:
        bases = []
        for stretch, matrix in zip(given.stretches, lagged):
            known = np.isfinite(stretch.columns[output])
            bases.append((known, basis(matrix[known])))
        elements += fit(given, output, bases)
    given.leave("corrected", elements)


if __name__ == "__main__":
    main(sys.argv[1])
