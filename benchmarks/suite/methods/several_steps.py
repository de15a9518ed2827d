"""several_steps.py FOLDER: plain least squares of predictions several steps ahead.

Gain, time constant and dead time of every element, from the model given
(benchmarks/real/least_squares.py). There is no test: it always corrects.
"""

import sys

import common
import least_squares  # of benchmarks/real

given = common.Given(sys.argv[1])
model = least_squares.correct(given.model, given.stretches, given.horizons)
given.leave("corrected", model["elements"])
