"""The equations of sim/quadruple_tank.h (linearise.py)."""

import math

STATE = (12.4, 12.7, 1.8, 1.4)
INPUTS = (3.0, 3.0)
OUTPUTS = (0, 1)
AGEING = {"pump1": (0.7, 0.95), "pump2": (0.7, 0.95), "split1": (0.9, 1.15),
          "split2": (0.9, 1.15), "outlet1": (0.75, 0.95), "outlet2": (0.75, 0.95),
          "outlet3": (0.75, 0.95), "outlet4": (0.75, 0.95)}
HELD = True
TOUR = ((-4, 5), (-4, 5))
FAR = ((0, (-6, -4)), (1, (3, 5)), (0, (3, 5)))

AREAS = (28.0, 32.0, 28.0, 32.0)


def derivative(state, inputs, pump1=1.0, pump2=1.0, split1=1.0, split2=1.0, outlet1=1.0,
               outlet2=1.0, outlet3=1.0, outlet4=1.0):
    outlets = (0.071 * outlet1, 0.057 * outlet2, 0.071 * outlet3, 0.057 * outlet4)
    out = [a * math.sqrt(2 * 981.0 * max(h, 0.0)) for a, h in zip(outlets, state)]
    flow1, flow2 = 3.33 * pump1 * inputs[0], 3.35 * pump2 * inputs[1]
    part1, part2 = 0.70 * split1, 0.60 * split2
    net = [part1 * flow1 + out[2] - out[0], part2 * flow2 + out[3] - out[1],
           (1.0 - part2) * flow2 - out[2], (1.0 - part1) * flow1 - out[3]]
    return [value / area for value, area in zip(net, AREAS)]
