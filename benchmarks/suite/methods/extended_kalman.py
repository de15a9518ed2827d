"""extended_kalman.py FOLDER: an extended Kalman filter of selected parameters.

Of each output gains, time constants (logarithms) and dead times x of its elements, and a
disturbance d:

    x(t + 1) = x(t),   d(t + 1) = d(t) + w(t),   y(t) = h_t(x) + d(t) + v(t),

h the simulated output. The record is gone through several times, from the same prior, linearised
where the time before ended (iterated, in steps of at most STEP; Ljung, IEEE Trans. Automatic
Control 24, 1979, 36). Estimated are parameters whose sensitivity, apart from that to those chosen
before, is above CUT standard deviations of the noise (Yao, Shaw, Kou, McAuley and Bacon, Polymer
Reaction Eng. 11, 2003, 563). The variance of v is that of differences, that of w a hundredth of it.
An element has aged if its parameters are outside their ellipsoid of LEVEL; intervals are those of
the filter.
"""

import sys

import common
import least_squares  # of benchmarks/real
import numpy as np
import responses

PRIOR = 0.3  # standard deviation of a parameter
CUT = 5.0
LEVEL = 1e-4
WALK = 1e-2
ROUNDS = 8
STEP = 0.3  # most that a parameter moves in a round
KEYS = ("gain", "time_constant", "delay")


class Output:
    def __init__(self, given, output):
        self.given, self.output = given, output
        self.elements = given.elements(output)
        self.noise = self.noise_variance()

    def moved(self, x):
        bounded = np.clip(x, -least_squares.FURTHEST, least_squares.FURTHEST)
        for i, element in enumerate(self.elements):
            least = -element["delay"] / responses.typical_time(element)
            bounded[3 * i + 2] = np.clip(bounded[3 * i + 2], least, 2.0)
        return [least_squares.moved(element, bounded[3 * i:3 * i + 3])
                for i, element in enumerate(self.elements)]

    def errors(self, x, stretch):
        return responses.errors_of(self.moved(x), stretch, self.output)

    def noise_variance(self):
        errors = [self.errors(np.zeros(3 * len(self.elements)), stretch)
                  for stretch in self.given.stretches]
        moves = np.concatenate([np.diff(error[np.isfinite(error)]) for error in errors])
        # Of the median, as the plant moves in a few samples only.
        return max(float(np.median(moves**2)) / 0.455 / 2.0, 1e-300) if len(moves) else 1e-300

    def slopes(self, x, stretch, free):
        value = self.errors(x, stretch)
        columns = []
        for i in free:
            beside = x.copy()
            beside[i] += 1e-3
            moved = self.errors(beside, stretch)
            if not np.nansum((moved - value)**2) > 0.0:  # at a bound
                beside[i] -= 2e-3
                moved = 2.0 * value - self.errors(beside, stretch)
            columns.append((value - moved) / 1e-3)
        return value, np.column_stack(columns)

    def select(self):
        """Indices of parameters, most sensitive first."""
        count = 3 * len(self.elements)
        parts = [self.slopes(np.zeros(count), stretch, range(count))[1]
                 for stretch in self.given.stretches]
        parts = [part[np.isfinite(part).all(axis=1)] for part in parts]
        rest = PRIOR * np.vstack([part - part.mean(axis=0) for part in parts if len(part)])
        free = []
        while len(free) < count:
            sizes = np.linalg.norm(rest, axis=0)
            best = int(np.argmax(sizes))
            if sizes[best] < CUT * self.noise**0.5:
                break
            free.append(best)
            direction = rest[:, best] / sizes[best]
            rest = rest - np.outer(direction, direction @ rest)
            rest[:, free] = 0.0
        return free

    def filter(self, free):
        """x, and the covariance of its free parameters."""
        x = np.zeros(3 * len(self.elements))
        covariance = PRIOR**2 * np.eye(len(free))
        for _ in range(ROUNDS):
            centre, covariance = x.copy(), PRIOR**2 * np.eye(len(free))
            x = np.zeros(len(x))
            for stretch in self.given.stretches:
                x, covariance = self.through(stretch, x, covariance, free, centre)
            x[free] = np.clip(x[free], centre[free] - STEP, centre[free] + STEP)
        return x, covariance

    def through(self, stretch, x, covariance, free, centre):
        size = len(free)
        state = np.append(x[free], 0.0)
        spread = np.zeros((size + 1, size + 1))
        spread[:size, :size] = covariance
        spread[size, size] = 1e6 * self.noise
        value, slope = self.slopes(centre, stretch, free)
        value = value + slope @ centre[free]
        for row, measured in zip(np.column_stack([slope, np.ones(len(value))]), value):
            spread[size, size] += WALK * self.noise
            if np.isfinite(measured):
                gain = spread @ row
                gain /= row @ gain + self.noise
                state = state + gain * (measured - row @ state)
                spread = spread - np.outer(gain, row @ spread)
        x = x.copy()
        x[free] = state[:size]
        return x, spread[:size, :size]


def aged_in(free, x, covariance, elements):
    for i in range(elements):
        own = [k for k, parameter in enumerate(free) if parameter // 3 == i]
        if own:
            part = x[[free[k] for k in own]]
            distance = part @ np.linalg.pinv(covariance[np.ix_(own, own)]) @ part
            if common.chi_square_tail(distance, len(own)) < LEVEL:
                yield i


def intervals(one, free, x, covariance):
    for k, parameter in enumerate(free):
        element, key, ends = one.elements[parameter // 3], KEYS[parameter % 3], []
        for sign in (-1.96, 1.96):
            point = x.copy()
            point[parameter] += sign * max(covariance[k, k], 0.0)**0.5
            ends.append(one.moved(point)[parameter // 3].get(key))
        if None not in ends:
            yield element["output"], element["input"], key, min(ends), max(ends)


def main(folder):
    given = common.Given(folder)
    elements, aged, ranges = [], [], []
    for output in given.outputs:
        if not given.elements(output):
            continue
        one = Output(given, output)
        free = one.select()
        if not free:
            elements += one.elements
            continue
        x, covariance = one.filter(free)
        found = list(aged_in(free, x, covariance, len(one.elements)))
        kept = [k for k, parameter in enumerate(free) if parameter // 3 in found]
        x[[parameter for parameter in range(len(x)) if parameter // 3 not in found]] = 0.0
        elements += one.moved(x)
        aged += [(output, one.elements[i]["input"]) for i in found]
        ranges += intervals(one, [free[k] for k in kept], x, covariance[np.ix_(kept, kept)])
    given.leave("corrected" if aged else "no_change", elements if aged else None, aged, ranges)


if __name__ == "__main__":
    main(sys.argv[1])
