"""Finite impulse responses without a prior model, by a stable-spline kernel.

For each output

    y = Σ_j Φ_j g_j + b 1 + e,   g_j ~ N(0, c_j K(α_j)),   K_st = α^max(s, t) (TC),

Φ_j the past of input j, at rest before the window, impulse responses held over a few samples. c_j,
α_j and the noise variance maximise the marginal likelihood (Chen, Ohlsson and Ljung, Automatica 48,
2012) in coordinates, α over the grid of time constants; then g is its posterior mean. kernel.py is
the method.
"""

import numpy as np

ROUNDS = 4


def regressors(windows, p, samples, hold):
    """Φ of all windows for each input, and the windows' indicators."""
    columns = -(-samples // hold)
    phis, ones = [], []
    for number, window in enumerate(windows):
        inputs = window[:, p:]
        blocks = []
        for j in range(inputs.shape[1]):
            past = np.concatenate([[0.0], np.cumsum(inputs[:, j])])  # sums before each sample
            matrix = np.empty((len(window), columns))
            rows = np.arange(len(window))
            for c in range(columns):
                # The values of u_{k−1−c·hold} … u_{k−(c+1)·hold}.
                newest = np.maximum(rows - c * hold, 0)
                oldest = np.maximum(rows - (c + 1) * hold, 0)
                matrix[:, c] = past[newest] - past[oldest]
            blocks.append(matrix)
        phis.append(np.hstack(blocks))
        indicator = np.zeros((len(window), len(windows)))
        indicator[:, number] = 1.0
        ones.append(indicator)
    return np.vstack(phis), np.vstack(ones)


def factor(columns, alpha):
    """L with L Lᵀ = K."""
    index = np.arange(1, columns + 1)
    kernel = alpha ** np.maximum.outer(index, index)
    return np.linalg.cholesky(kernel + 1e-14 * kernel[0, 0] * np.eye(columns))


class Output:
    """The marginal likelihood of one output, from second moments."""

    def __init__(self, gram, cross, square, rows, columns, inputs):
        self.gram, self.cross, self.square = gram, cross, square
        self.rows, self.columns, self.inputs = rows, columns, inputs

    def prior(self, scales, alphas):
        root = np.zeros_like(self.gram)
        for j in range(self.inputs):
            part = slice(j * self.columns, (j + 1) * self.columns)
            root[part, part] = np.sqrt(scales[j]) * factor(self.columns, alphas[j])
        return root

    def solve(self, scales, alphas):
        """(−2 log marginal likelihood with the best noise variance, g). Scales are relative to
        the noise's variance."""
        root = self.prior(scales, alphas)
        inner = np.eye(len(root)) + root.T @ self.gram @ root
        lower = np.linalg.cholesky(inner)
        half = np.linalg.solve(lower, root.T @ self.cross)
        residual = max(self.square - half @ half, 1e-300)
        value = self.rows * np.log(residual / self.rows) + 2.0 * np.sum(np.log(np.diag(lower)))
        return value, root @ np.linalg.solve(lower.T, half)

    def maximise(self):
        scales = [10.0 / max(self.gram.trace() / len(self.gram), 1e-300)] * self.inputs
        scales = [scale * self.rows / self.columns for scale in scales]
        alphas = [np.exp(-8.0 / self.columns)] * self.inputs
        best = self.solve(scales, alphas)[0]
        step = 10.0
        for _ in range(ROUNDS):
            for j in range(self.inputs):
                for decay in (3.0, 5.0, 8.0, 12.0, 20.0, 35.0):
                    trial = alphas[:j] + [np.exp(-decay / self.columns)] + alphas[j + 1:]
                    value = self.solve(scales, trial)[0]
                    if value < best:
                        best, alphas = value, trial
                for power in (2, 1, -1, -2):
                    trial = scales[:j] + [scales[j] * step**power] + scales[j + 1:]
                    value = self.solve(trial, alphas)[0]
                    if value < best:
                        best, scales = value, trial
            step = step**0.6
        return self.solve(scales, alphas)[1]
