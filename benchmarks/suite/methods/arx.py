"""arx.py FOLDER: autoregressive models with all inputs, refitted by elements of first order.

    y(t) = Σ a_k y(t − k) + Σ_j Σ b_jk u_j(t − k) + c + e(t)

by least squares (Ljung, System Identification, 1999, 4.2). The order is that whose model, fitted
without every fourth block of the record, simulates those blocks with the least squared error. Its
step responses are replaced by the nearest of first order with dead time. There is no test: it
always corrects.
"""

import sys

import common
import numpy as np

ORDERS = (3, 5, 10, 20, 40, 80)
BLOCKS = 16
MOST_ROWS = 20000


def regressors(given, stretch, output, order):
    """Rows from the order on, with their responses."""
    y = stretch.columns[output]
    count = len(y) - order
    columns = [y[order - k:order - k + count] for k in range(1, order + 1)]
    for name in given.inputs:
        u = stretch.columns[name] - stretch.columns[name][0]
        columns += [u[order - k:order - k + count] for k in range(1, order + 1)]
    return np.column_stack([*columns, np.ones(count)]), y[order:]


def solve(rows, right):
    known = np.isfinite(rows).all(axis=1) & np.isfinite(right)
    rows, right = rows[known][:MOST_ROWS], right[known][:MOST_ROWS]
    if len(right) < 2 * rows.shape[1]:
        return None
    scale = np.maximum(np.abs(rows).max(axis=0), 1e-300)
    gram = (rows / scale).T @ (rows / scale)
    gram += 1e-10 * np.trace(gram) / len(gram) * np.eye(len(gram))
    return np.linalg.solve(gram, (rows / scale).T @ right) / scale


def simulate(theta, order, inputs, samples):
    """The response to deviations of inputs, from rest."""
    driven = np.zeros(samples)
    for j, u in enumerate(inputs):
        weights = theta[order * (j + 1):order * (j + 2)]
        driven += np.convolve(u, np.concatenate([[0.0], weights]))[:samples]
    y = np.zeros(samples + order)
    backwards = theta[:order][::-1]
    for t in range(samples):
        y[t + order] = backwards @ y[t:t + order] + driven[t]
    return y[order:]


def loss(given, output, order):
    """Of the blocks held out."""
    held_rows, pieces = [], []
    for stretch in given.stretches:
        if len(stretch.time) <= 3 * order:
            continue
        rows, right = regressors(given, stretch, output, order)
        block = np.arange(len(right)) * BLOCKS // len(right)
        held_rows.append(block % 4 == 3)
        pieces.append((stretch, rows, right))
    if not pieces:
        return np.inf
    theta = solve(np.vstack([rows[~held] for (_, rows, _), held in zip(pieces, held_rows)]),
                  np.concatenate([right[~held]
                                  for (_, _, right), held in zip(pieces, held_rows)]))
    if theta is None:
        return np.inf
    total = 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        for (stretch, _, right), held in zip(pieces, held_rows):
            inputs = [stretch.columns[name] - stretch.columns[name][0] for name in given.inputs]
            error = right - simulate(theta, order, inputs, len(stretch.time))[order:]
            error = error[held & np.isfinite(right)]
            total += float(np.sum((error - error.mean())**2)) if len(error) else 0.0
    return total if np.isfinite(total) else np.inf


def steps_of(given, output):
    losses = [loss(given, output, order) for order in ORDERS]
    if not np.isfinite(min(losses)):
        return None
    order = ORDERS[int(np.argmin(losses))]
    pieces = [regressors(given, stretch, output, order) for stretch in given.stretches
              if len(stretch.time) > 3 * order]
    theta = solve(np.vstack([rows for rows, _ in pieces]),
                  np.concatenate([right for _, right in pieces]))
    samples = given.settling()
    result = {}
    for j, name in enumerate(given.inputs):
        inputs = [np.full(samples, float(i == j)) for i in range(len(given.inputs))]
        result[output, name] = simulate(theta, order, inputs, samples)
    return result if all(np.isfinite(step).all() for step in result.values()) else None


def main(folder):
    given = common.Given(folder)
    steps = {}
    for output in given.outputs:
        found = steps_of(given, output)
        if found is None:
            given.leave("cannot_tell")
            return
        steps.update(found)
    given.leave("corrected", common.of_steps(given, steps))


if __name__ == "__main__":
    main(sys.argv[1])
