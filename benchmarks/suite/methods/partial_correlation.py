"""partial_correlation.py FOLDER: detection by partial correlation of inputs and model residuals.

Badwe, Gudi, Patwardhan, Shah and Meka, J. Process Control 19 (2009) 1305. With e the residuals of
the model and û the part of the inputs that set points explain (all of them without set points),
both as means over a twentieth of the settling time:

1. ε_i: û_i less its regression on lags, both ways, of the other û;
2. η_i: e_j less its regression on the same lags;
3. ε_i is whitened by an autoregression, η_i filtered alike;
4. the model of input i and output j is wrong if a correlation of ε_i(t) and η_i(t + k), k up to the
   settling time, is further from 0 than LEVEL allows under independence, for all pairs and lags
   together.
"""

import math
import sys

import common
import instruments
import numpy as np

LEVEL = 0.01
LAGS = 20
ORDER = 5  # of the autoregressions


def lagged(series, steps):
    """Lags both ways, zero beyond the ends."""
    columns = []
    for lag in steps:
        column = np.zeros(len(series))
        if lag >= 0:
            column[lag:] = series[:len(series) - lag]
        else:
            column[:lag] = series[-lag:]
        columns.append(column)
    return np.column_stack(columns)


def explained(given, stretch):
    """Inputs, as far as set points explain them."""
    inputs = {name: stretch.columns[name] - stretch.columns[name].mean() for name in given.inputs}
    space = instruments.basis(instruments.instruments(given, stretch))
    if space.shape[1] == 0:
        return inputs
    return {name: space @ (space.T @ values) for name, values in inputs.items()}


def means(given, values):
    """Over twentieths of the settling time, where anything is known."""
    hold = max(1, given.settling() // LAGS)
    blocks = values[:len(values) // hold * hold].reshape(-1, hold)
    known = np.isfinite(blocks)
    counts = known.sum(axis=1)
    sums = np.where(known, blocks, 0.0).sum(axis=1)
    return np.where(counts > 0, sums / np.maximum(counts, 1), math.nan)


def partial(name, other_names, parts, errors):
    """(ε, η) of all stretches, whitened."""
    steps = range(-LAGS // 2, LAGS // 2 + 1)
    pairs = []
    for inputs, error in zip(parts, errors):
        known = np.isfinite(error)
        if known.sum() < 2 * LAGS:
            continue
        others = [lagged(inputs[other], steps) for other in other_names]
        own, eta = inputs[name], np.where(known, error, 0.0)
        if others and np.hstack(others).shape[1] < known.sum():
            matrix = np.hstack(others)
            own = own - matrix @ np.linalg.lstsq(matrix, own, rcond=1e-8)[0]
            eta = eta - np.where(known, matrix @ np.linalg.lstsq(matrix[known], error[known],
                                                                 rcond=1e-8)[0], 0.0)
        pairs.append((own, eta))
    if not pairs:
        return []
    own = common.autoregression([one for one, _ in pairs], ORDER)
    return [(common.filtered(one, own), common.filtered(other, own)) for one, other in pairs]


def largest_correlation(pairs):
    """Over lags, times the root of the samples."""
    power = math.sqrt(sum(one @ one for one, _ in pairs) * sum(two @ two for _, two in pairs))
    if not power > 0.0:
        return 0.0
    count = sum(len(one) for one, _ in pairs)
    values = [abs(sum(one[:len(one) - k] @ two[k:] for one, two in pairs)) / power
              for k in range(LAGS + 1)]
    return max(values) * math.sqrt(count)


def wrong(given, plain=False):
    """Pairs (output, input) whose model is wrong; plain: by correlation that is not partial."""
    parts = [{name: means(given, values) for name, values in explained(given, stretch).items()}
             for stretch in given.stretches]
    tests = len(given.inputs) * len(given.outputs) * (LAGS + 1)
    bound = common.normal_quantile(0.5 * LEVEL / tests)
    found = []
    for output in given.outputs:
        errors = [means(given, error) for error in given.errors(given.elements(output), output)]
        for name in given.inputs:
            others = [] if plain else [other for other in given.inputs if other != name]
            pairs = partial(name, others, parts, errors)
            if pairs and largest_correlation(pairs) > bound:
                found.append((output, name))
    return found


def main(folder):
    given = common.Given(folder)
    aged = wrong(given)
    given.leave("mismatch" if aged else "no_change", aged=aged)


if __name__ == "__main__":
    main(sys.argv[1])
