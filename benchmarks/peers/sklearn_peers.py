"""scikit-learn on a problem that peer_problem wrote.

sklearn_peers.py lars DIR REPEATS
    lars_path_gram to alpha = 0, REPEATS times; coefficients at lambdas.npy by
    interpolation.
sklearn_peers.py lasso DIR TOLERANCE
    lasso_path (coordinate descent on the Gram matrix) at lambdas.npy; its stop
    is a duality gap below TOLERANCE ‖y‖².

Prints processor and wall seconds, a line for each repetition, and writes the
coefficients to DIR/coefficients.npy.
"""

import sys
import time
import warnings

import numpy as np
from sklearn.linear_model import lars_path_gram, lasso_path

warnings.filterwarnings("ignore")


def load(directory, name):
    return np.load(f"{directory}/{name}.npy")


def save(directory, coefficients):
    np.save(f"{directory}/coefficients.npy", np.asfortranarray(coefficients))


class Stopwatch:
    def __init__(self):
        self.start = time.process_time()
        self.wall_start = time.perf_counter()

    def print(self):
        used = time.process_time() - self.start
        wall = time.perf_counter() - self.wall_start
        print(f"{used:.6f} {wall:.6f}", flush=True)


def run_lars(directory, repeats):
    gram = load(directory, "gram")
    correlation = load(directory, "correlation")[:, 0]
    for _ in range(repeats):
        # lars_path_gram exchanges rows and columns of its arguments.
        arguments = dict(Xy=correlation.copy(), Gram=gram.copy(order="F"))
        stopwatch = Stopwatch()
        alphas, _, path = lars_path_gram(
            **arguments, n_samples=1, method="lasso", max_iter=10**6
        )
        stopwatch.print()
    lambdas = load(directory, "lambdas")[:, 0]
    save(
        directory,
        [np.interp(lambdas, alphas[::-1], row[::-1]) for row in path],
    )


def run_lasso(directory, tolerance):
    x = load(directory, "x")
    y = load(directory, "y")[:, 0]
    rows = len(y)
    gram = rows * load(directory, "gram")
    correlation = rows * load(directory, "correlation")[:, 0]
    stopwatch = Stopwatch()
    _, coefficients, _ = lasso_path(
        x,
        y,
        alphas=load(directory, "lambdas")[:, 0],
        precompute=gram,
        Xy=correlation,
        copy_X=False,
        tol=tolerance,
        max_iter=10**9,
    )
    stopwatch.print()
    save(directory, coefficients)


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("lars", "lasso"):
        sys.exit(__doc__)
    if sys.argv[1] == "lars":
        run_lars(sys.argv[2], int(sys.argv[3]))
    else:
        run_lasso(sys.argv[2], float(sys.argv[3]))
