"""The equations of sim/ph_neutralisation.h (linearise.py)."""

import math

STATE = (14.0, -0.432, 0.528, 7.0)
INPUTS = (16.6, 15.55)
OUTPUTS = (0, 3)
AGEING = {"acid": (0.75, 0.95), "base": (0.75, 0.95), "buffer": (0.7, 1.3),
          "outlet": (0.8, 0.95), "electrode_slope": (0.8, 0.95), "electrode_lag": (1.3, 3.0)}
HELD = True
TOUR = ((-2, 2), (-0.8, 0.5))
FAR = ((1, (-1.0, -0.7)), (0, (1.5, 2.5)), (1, (0.3, 0.6)))

CHARGES = (3.00, -30.0, -3.05)
CARBONATES = (0.0, 30.0, 0.050)


def charge(ph, wa, wb):
    """Of all ions [mmol/L]."""
    first, second = 10.0 ** (6.35 - ph), 10.0 ** (ph - 10.25)
    return (wa + 1e3 * (10.0 ** (ph - 14.0) - 10.0 ** -ph) +
            wb * (1.0 + 2.0 * second) / (1.0 + first + second))


def ph_of(wa, wb):
    """By bisection: the charge grows with pH."""
    low, high = -2.0, 16.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if charge(middle, wa, wb) > 0.0:
            high = middle
        else:
            low = middle


def derivative(state, inputs, acid=1.0, base=1.0, buffer=1.0, outlet=1.0, electrode_slope=1.0,
               electrode_lag=1.0):
    level, wa, wb, shown = state
    streams = (acid * inputs[0], buffer * 0.55, base * inputs[1])
    volume = 207.0 * level
    return [(sum(streams) - outlet * 8.75 * math.sqrt(level)) / 207.0,
            sum(q * (c - wa) for q, c in zip(streams, CHARGES)) / volume,
            sum(q * (c - wb) for q, c in zip(streams, CARBONATES)) / volume,
            (7.0 + electrode_slope * (ph_of(wa, wb) - 7.0) - shown) / (15.0 * electrode_lag)]
