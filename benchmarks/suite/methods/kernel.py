"""kernel.py FOLDER: finite impulse responses without a prior model, by a stable-spline kernel.

kernel_fir.py (Chen, Ohlsson and Ljung, Automatica 48, 2012, 1525), with all inputs and at most TAPS
values for each impulse response; step responses are replaced by the nearest of first order with
dead time. There is no test: it always corrects.
"""

import sys

import common
import kernel_fir
import numpy as np

MOST_SAMPLES = 6000
TAPS = 80


def thinned(given):
    """Windows in deviations from their first rows, of every n-th sample where there are many."""
    total = sum(len(stretch.time) for stretch in given.stretches)
    stride = max(1, -(-total // MOST_SAMPLES))
    windows = []
    for stretch in given.stretches:
        columns = [stretch.columns[name] for name in (*given.outputs, *given.inputs)]
        window = np.column_stack(columns)[::stride]
        window[:, len(given.outputs):] -= window[0, len(given.outputs):]
        if len(window) > 10:
            windows.append(window)
    return windows, stride


def main(folder):
    given = common.Given(folder)
    windows, stride = thinned(given)
    p, m = len(given.outputs), len(given.inputs)
    samples = max(10, given.settling() // stride)
    hold = max(1, -(-samples // TAPS))
    phi, ones = kernel_fir.regressors(windows, p, samples, hold)
    outputs = np.vstack([window[:, :p] for window in windows])
    columns = phi.shape[1] // m
    steps = {}
    for i, output in enumerate(given.outputs):
        known = np.isfinite(outputs[:, i])
        if known.sum() < 20:
            given.leave("cannot_tell")
            return
        some, indicator, y = phi[known], ones[known], outputs[known, i]
        counts = np.maximum(indicator.sum(axis=0), 1.0)[:, None]
        some = some - indicator @ (indicator.T @ some / counts)
        y = y - indicator @ (indicator.T @ y[:, None] / counts)[:, 0]
        g = kernel_fir.Output(some.T @ some, some.T @ y, y @ y, len(y), columns, m).maximise()
        for j, name in enumerate(given.inputs):
            impulse = np.repeat(g[j * columns:(j + 1) * columns], hold)[:samples - 1]
            steps[output, name] = np.concatenate([[0.0], np.cumsum(impulse)])
    given.interval *= stride
    given.leave("corrected", common.of_steps(given, steps))


if __name__ == "__main__":
    main(sys.argv[1])
