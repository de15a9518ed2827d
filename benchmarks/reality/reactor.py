"""The linear model of the van de Vusse reactor at any steady state, for the truth of the benchmark.

The equations are those of sim/van_de_vusse.h, written down again; at the operating point of
configs/van_de_vusse.json the model is that file's.
"""

import math

import plants

FEED, HEAT = 8.0, -1113.5


def derivative(state, inputs, activity, heat_transfer):
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


def jacobian(function, point):
    """∂f_i/∂x_j by central differences."""
    columns = []
    for j, value in enumerate(point):
        step = 1e-5 * max(1.0, abs(value))
        ends = []
        for sign in (1, -1):
            moved = list(point)
            moved[j] += sign * step
            ends.append(function(moved))
        columns.append([(up - down) / (2 * step) for up, down in zip(*ends)])
    return [list(row) for row in zip(*columns)]


def steady_state(inputs, activity, heat_transfer):
    state = [2.14, 1.09, 114.2, 112.9]
    for _ in range(100):
        values = derivative(state, inputs, activity, heat_transfer)
        matrix = jacobian(lambda x: derivative(x, inputs, activity, heat_transfer), state)
        move = plants.solve(matrix, [-value for value in values])
        longest = max(abs(part) / max(1.0, abs(x)) for part, x in zip(move, state))
        damping = min(1.0, 0.2 / longest) if longest > 0 else 1.0
        state = [x + damping * part for x, part in zip(state, move)]
        if longest < 1e-13:
            break
    return state


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def transfer_functions(A, B, outputs):
    """Numerators (of C B, row by row) and denominator of C (s I − A)⁻¹ B, by Faddeev and
    LeVerrier."""
    n = len(A)
    M = [[float(i == j) for j in range(n)] for i in range(n)]
    denominator = [1.0]
    numerators = [[[] for _ in B[0]] for _ in outputs]
    for k in range(1, n + 1):
        MB = product(M, B)
        for row, output in zip(numerators, outputs):
            for j, numerator in enumerate(row):
                numerator.append(MB[output][j])
        AM = product(A, M)
        coefficient = -sum(AM[i][i] for i in range(n)) / k
        denominator.append(coefficient)
        M = [[AM[i][j] + coefficient * (i == j) for j in range(n)] for i in range(n)]
    return numerators, denominator


def model(activity=1.0, heat_transfer=1.0):
    """configs/van_de_vusse.json with other elements."""
    inputs = [FEED, HEAT]
    state = steady_state(inputs, activity, heat_transfer)
    A = jacobian(lambda x: derivative(x, inputs, activity, heat_transfer), state)
    B = jacobian(lambda u: derivative(state, u, activity, heat_transfer), inputs)
    numerators, denominator = transfer_functions(A, B, outputs=(1, 2))
    result = plants.PLANTS["reactor"].read()
    rows = [channel["name"] for channel in result["outputs"]]
    columns = [channel["name"] for channel in result["inputs"]]
    last = denominator[-1]
    for element in result["elements"]:
        numerator = numerators[rows.index(element["output"])][columns.index(element["input"])]
        element["numerator"] = [value / last for value in numerator]
        element["denominator"] = [value / last for value in denominator]
    return result
