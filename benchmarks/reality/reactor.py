"""The equations of sim/van_de_vusse.h (linearise.py)."""

import math

STATE = (2.14, 1.09, 114.2, 112.9)
INPUTS = (8.0, -1113.5)
OUTPUTS = (1, 2)
AGEING = {"activity": (0.8, 0.95), "heat_transfer": (0.6, 1.0)}
HELD = False
TOUR = ((-0.1, 0.05), (-4, 4))
FAR = ((0, (-0.12, -0.06)), (1, (2, 4)), (0, (-0.02, 0.03)))


def derivative(state, inputs, activity=1.0, heat_transfer=1.0):
    a, b, temperature, jacket = state
    feed, heat = inputs
    kelvin = temperature + 273.15
    k1 = activity * 1.287e12 * math.exp(-9758.3 / kelvin)
    k3 = activity * 9.043e9 * math.exp(-8560.0 / kelvin)
    released = 4.2 * k1 * a - 11.0 * k1 * b - 41.85 * k3 * a * a
    capacity = 0.9342 * 3.01
    to_jacket = heat_transfer * 4032.0 * 0.215 * (temperature - jacket)
    return [feed * (5.10 - a) - k1 * a - k3 * a * a,
            -feed * b + k1 * a - k1 * b,
            feed * (104.9 - temperature) - released / capacity - to_jacket / (capacity * 10.0),
            (heat + to_jacket) / (5.0 * 2.0)]
