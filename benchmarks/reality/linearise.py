"""The linear model of a non-linear plant at a steady state, for the truth of the benchmark.

A plant is a module of its equations, those of a header in sim/ written down again:

    derivative(state, inputs, **factors)   ẋ; the factors of what ages are 1 unless given
    STATE                                  near its steady state
    INPUTS                                 at which the file of its process model is linearised
    OUTPUTS                                places of the states that are outputs
    AGEING                                 what ages, and the range that a factor is drawn from
    HELD                                   whether operators hold the outputs where they were
                                           while it ages, or leave the inputs alone
    TOUR                                   ranges of the outputs' set points
    FAR                                    three far set points: place of the output, range
"""

import math

import plants

SMALL = 1e-7  # errors of the differences are below it, what a state does to another is not


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


def root(function, point):
    """Where a function of as many values is zero, by Newton's method with short steps."""
    for _ in range(100):
        move = plants.solve(jacobian(function, point), [-value for value in function(point)])
        longest = max(abs(part) / max(1.0, abs(x)) for part, x in zip(move, point))
        damping = min(1.0, 0.2 / longest) if longest > 0 else 1.0
        point = [x + damping * part for x, part in zip(point, move)]
        if longest < 1e-13:
            break
    return point


def at_rest(equations, **factors):
    """State and inputs of the plant with these factors."""
    inputs = list(equations.INPUTS)
    state = root(lambda x: equations.derivative(x, inputs), list(equations.STATE))
    if not factors:
        return state, inputs
    if not equations.HELD:
        return root(lambda x: equations.derivative(x, inputs, **factors), state), inputs
    count = len(state)

    def both(point):
        return [*equations.derivative(point[:count], point[count:], **factors),
                *(point[output] - state[output] for output in equations.OUTPUTS)]
    point = root(both, [*state, *inputs])
    return point[:count], point[count:]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def product(A, b):
    return [dot(row, b) for row in A]


def transposed(A):
    return [list(row) for row in zip(*A)]


def reached(A, b, c):
    """A, b and c without the states that b does not reach: on an orthonormal basis of the span of
    b, A b, A² b, …"""
    rate = max(math.hypot(*row) for row in A)
    basis, vector = [], b
    while len(basis) < len(A):
        size = math.hypot(*vector)
        if basis and size < SMALL:
            break
        basis.append([value / size for value in vector])
        vector = [value / rate for value in product(A, basis[-1])]
        for _ in range(2):  # twice is enough for rounding
            for other in basis:
                part = dot(other, vector)
                vector = [x - part * y for x, y in zip(vector, other)]
    images = [product(A, one) for one in basis]
    return ([[dot(one, image) for image in images] for one in basis],
            [dot(one, b) for one in basis], [dot(one, c) for one in basis])


def transfer_function(A, b, c):
    """Numerator and denominator of c (s I − A)⁻¹ b, by Faddeev and LeVerrier; denominator 1 at
    s = 0."""
    n = len(A)
    rate = max(math.hypot(*row) for row in A)
    M = [[float(i == j) for j in range(n)] for i in range(n)]
    numerator, denominator = [], [1.0]
    for k in range(1, n + 1):
        numerator.append(dot(c, product(M, b)))
        AM = transposed([product(A, column) for column in transposed(M)])
        coefficient = -sum(AM[i][i] for i in range(n)) / k
        denominator.append(coefficient)
        M = [[AM[i][j] + coefficient * (i == j) for j in range(n)] for i in range(n)]
    sizes = [abs(value) * rate ** -k for k, value in enumerate(numerator)]
    while sizes[0] < SMALL * max(sizes):
        sizes, numerator = sizes[1:], numerator[1:]
    last = denominator[-1]
    return [value / last for value in numerator], [value / last for value in denominator]


def model(plant, equations, **factors):
    """The process model of a plant with the elements that it has with these factors."""
    state, inputs = at_rest(equations, **factors)
    # In parts of the states, so that what is small is small in all units.
    scale = [abs(value) or 1.0 for value in state]
    A = jacobian(lambda x: equations.derivative(x, inputs, **factors), state)
    A = [[value * scale[j] / scale[i] for j, value in enumerate(row)] for i, row in enumerate(A)]
    B = jacobian(lambda u: equations.derivative(state, u, **factors), inputs)
    B = [[value / size for value in row] for row, size in zip(B, scale)]
    result = plant.read()
    rows = [channel["name"] for channel in result["outputs"]]
    columns = [channel["name"] for channel in result["inputs"]]
    for element in result["elements"]:
        output = equations.OUTPUTS[rows.index(element["output"])]
        b = [row[columns.index(element["input"])] for row in B]
        c = [scale[output] * (i == output) for i in range(len(state))]
        A_reached, b, c = reached(A, b, c)
        A_seen, c, b = reached(transposed(A_reached), c, b)
        numerator, denominator = transfer_function(transposed(A_seen), b, c)
        if "gain" in element:
            (element["gain"],), (element["time_constant"], _) = numerator, denominator
        else:
            element["numerator"], element["denominator"] = numerator, denominator
    return result
