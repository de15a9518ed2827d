"""closest_model.py FOLDER: the model closest to the one given that fits as well as any.

Parameters (gain, time constant, dead time of each element) are freed one at a time, always that
which lowers the squared errors most, while

    N log S + (log N + 2 log q) k

falls, S the squared simulation errors whitened by an autoregression, k of q parameters free (the
extended information criterion of Chen and Chen, Biometrika 95, 2008, 759; forward selection as in
Draper and Smith, Applied Regression Analysis, 1998). Intervals are those of least squares.
"""

import math
import sys

import common
import least_squares  # of benchmarks/real
import numpy as np
import responses

ORDER = 30
KEYS = ("gain", "time_constant", "delay")


class Output:
    def __init__(self, given, output):
        self.given, self.output = given, output
        self.elements = given.elements(output)
        count = 3 * len(self.elements)
        furthest = least_squares.FURTHEST
        self.lower, self.upper = np.full(count, -furthest), np.full(count, furthest)
        for i, element in enumerate(self.elements):
            self.lower[3 * i + 2] = -element["delay"] / responses.typical_time(element)
            self.upper[3 * i + 2] = 2.0
        self.whitener = np.zeros(0)
        self.whitener = common.autoregression(
            self.given.errors(self.moved(self.fitted(range(count))), output), ORDER)

    def moved(self, x):
        return [least_squares.moved(element, x[3 * i:3 * i + 3])
                for i, element in enumerate(self.elements)]

    def residuals(self, x):
        errors = self.given.errors(self.moved(x), self.output)
        whitened = common.rows_of([common.filtered(error, self.whitener) for error in errors])
        # Where so little is measured that nothing can be whitened, errors stand as they are.
        return whitened if len(whitened) > 20 else common.rows_of(errors)

    def fitted(self, free, start=None):
        free = list(free)
        x = np.zeros(len(self.lower)) if start is None else start.copy()
        if not free:
            return x
        scale = math.sqrt(float(np.sum(self.residuals(x)**2))) or 1.0

        def residuals(part):
            point = x.copy()
            point[free] = part
            return self.residuals(point) / scale

        point = x.copy()
        point[free] = least_squares.minimise(residuals, x[free], self.lower[free],
                                             self.upper[free])
        return point

    def slopes(self, x):
        value = self.residuals(x)
        columns = []
        for i in range(len(x)):
            step = 1e-4 if x[i] + 1e-4 <= self.upper[i] else -1e-4
            beside = x.copy()
            beside[i] += step
            columns.append((self.residuals(beside) - value) / step)
        return value, np.column_stack(columns)

    def next_free(self, x, free):
        """The parameter that lowers the linearised squared errors most."""
        value, slopes = self.slopes(x)
        falls = {}
        for i in set(range(len(x))) - set(free):
            some = slopes[:, [*free, i]]
            falls[i] = value @ some @ np.linalg.lstsq(some, value, rcond=1e-10)[0]
        return max(sorted(falls), key=falls.get)

    def select(self):
        count = len(self.lower)
        x, free = np.zeros(count), []
        value = self.residuals(x)
        rows = len(value)
        price = math.log(rows) + 2.0 * math.log(count)
        best = rows * math.log(max(value @ value, 1e-300))
        while len(free) < min(count, rows // 4):
            chosen = sorted([*free, self.next_free(x, free)])
            tried = self.fitted(chosen, x)
            value = self.residuals(tried)
            score = rows * math.log(max(value @ value, 1e-300)) + price * len(chosen)
            if score >= best:
                break
            x, free, best = tried, chosen, score
        return x, free

    def intervals(self, x, free):
        value, slopes = self.slopes(x)
        some = slopes[:, free]
        covariance = np.linalg.pinv(some.T @ some) * (value @ value) / max(
            1, len(value) - len(free))
        for spread, i in zip(np.sqrt(np.diag(covariance)), free):
            element, key = self.elements[i // 3], KEYS[i % 3]
            ends = []
            for sign in (-1.96, 1.96):
                point = x.copy()
                point[i] += sign * spread
                moved = self.moved(point)[i // 3]
                if key not in moved:
                    break
                ends.append(moved[key])
            if len(ends) == 2:
                yield element["output"], element["input"], key, min(ends), max(ends)


def main(folder):
    given = common.Given(folder)
    elements, aged, intervals = [], [], []
    for output in given.outputs:
        if not given.elements(output):
            continue
        one = Output(given, output)
        x, free = one.select()
        elements += one.moved(x)
        if free:
            aged += [(output, one.elements[i]["input"]) for i in sorted({i // 3 for i in free})]
            intervals += one.intervals(x, free)
    given.leave("corrected" if aged else "no_change", elements if aged else None, aged, intervals)


if __name__ == "__main__":
    main(sys.argv[1])
