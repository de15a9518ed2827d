"""The plants of the benchmark, and arithmetic on process models as JSON has them."""

import copy
import dataclasses
import json
import math
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]


@dataclasses.dataclass(frozen=True)
class Plant:
    """A model and the loop that its records come from."""

    model: str
    steps: tuple  # change of each output's set point
    settling: float  # time between changes of set points
    sample_time: float
    control_period: float
    horizon: int  # control periods
    move_weight: float = 1.0
    noise: float = 0.03  # standard deviation, in steps of the set points
    simulated: str = None  # --plant, where it is no process model

    def disturbances(self):
        return disturbances(self.read())

    def read(self):
        return json.loads((ROOT / self.model).read_text())

    def flags(self):
        return {
            "sample_time": self.sample_time,
            "control_period": self.control_period,
            "prediction_horizon": self.horizon,
            # Weights in units of the steps, and of the inputs that make them.
            "output_weight": ",".join(f"{1.0 / step**2:.6g}" for step in self.steps),
            "move_weight": ",".join(f"{self.move_weight / size**2:.6g}"
                                    for size in input_sizes(self.read(), self.steps)),
        }


PLANTS = {
    "wood_berry": Plant("configs/wood_berry.json", (1, 1), 150, 0.5, 1, 30),
    "two_by_two": Plant("benchmarks/plants/two_by_two.json", (1, 1), 120, 0.4, 1.2, 30),
    "three_by_three": Plant("benchmarks/plants/three_by_three.json", (1, 1, 1), 400, 2, 6, 30),
    "vinante_luyben": Plant("benchmarks/plants/vinante_luyben.json", (1, 1), 100, 0.2, 0.6, 40),
    "splitter": Plant("configs/splitter.json", (-0.5, 0.5, 2), 250, 1, 2, 40),
    "wardle_wood": Plant("benchmarks/plants/wardle_wood.json", (0.1, 0.1), 400, 2, 6, 30),
    "ogunnaike_ray": Plant("benchmarks/plants/ogunnaike_ray.json", (0.5, 0.5, 10), 150, 0.5, 1, 40),
    "reactor": Plant("configs/van_de_vusse.json", (0.02, 1), 1, 0.01, 0.02, 40,
                     simulated="van_de_vusse"),
    "tanks": Plant("configs/quadruple_tank.json", (1, 1), 500, 2, 4, 40,
                   simulated="quadruple_tank"),
    "neutralisation": Plant("configs/ph_neutralisation.json", (0.5, 0.3), 800, 3, 6, 40,
                            simulated="ph_neutralisation"),
    "stripper": Plant("benchmarks/plants/stripper.json", (1, 1), 90, 0.3, 0.6, 40),
    "fired_heater": Plant("benchmarks/plants/fired_heater.json", (2, 0.5), 80, 0.25, 0.5, 40),
    "mixing_tank": Plant("benchmarks/plants/mixing_tank.json", (1, 1), 300, 1, 2, 40),
    "dryer": Plant("configs/dryer.json", (1, 5), 600, 4, 8, 40),
    # Prett and Garcia, Fundamental Process Control, Butterworths 1988: y1, y2, y7 of u1, u2, u3.
    "shell_fractionator": Plant("benchmarks/plants/shell_fractionator.json", (1, 1, 1), 400, 2, 4,
                                40),
    # Shen, Cai and Li, Ind. Eng. Chem. Res. 49 (2010) 761: four rooms of an air-conditioned house.
    "four_rooms": Plant("benchmarks/plants/four_rooms.json", (1, 1, 1, 1), 900, 4, 8, 40),
    # Doukas and Luyben, Instrumentation Technology 25 (1978) 43, as Luyben has it, Ind. Eng. Chem.
    # Process Des. Dev. 25 (1986) 654: a column with a side stream, three components.
    "doukas_luyben": Plant("benchmarks/plants/doukas_luyben.json", (1, 1, 0.2, 1), 400, 1, 2, 40),
}

# Thresholds may be chosen on the first; the second is for reports.
SETS = {
    "tuning": (("wood_berry", "two_by_two", "three_by_three"), 1),
    "reporting": (("vinante_luyben", "splitter", "wardle_wood", "ogunnaike_ray"), 1001),
}
# The adversary has these beside them.
ADVERSARY = {"tuning": ("stripper", "fired_heater"), "reporting": ("mixing_tank", "dryer")}


def static_gain(element):
    if "gain" in element:
        return element["gain"]
    return element["numerator"][-1] / element["denominator"][-1]


def gain_matrix(model):
    rows = [channel["name"] for channel in model["outputs"]]
    columns = [channel["name"] for channel in model["inputs"]]
    matrix = [[0.0] * len(columns) for _ in rows]
    for element in model["elements"]:
        row = matrix[rows.index(element["output"])]
        row[columns.index(element["input"])] = static_gain(element)
    return matrix


def solve(matrix, right):
    """Gaussian elimination with partial pivoting."""
    n = len(matrix)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(i + 1, n):
            factor = rows[r][i] / rows[i][i]
            rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    result = [0.0] * n
    for i in reversed(range(n)):
        rest = sum(rows[i][j] * result[j] for j in range(i + 1, n))
        result[i] = (rows[i][n] - rest) / rows[i][i]
    return result


def disturbances(model):
    """The names of the inputs that are measured and not moved."""
    return [channel["name"] for channel in model["inputs"] if channel.get("role") == "disturbance"]


def input_sizes(model, steps):
    """How far each input goes at most when one output steps alone; of a disturbance, what makes
    half a step of the output that answers it most."""
    matrix = gain_matrix(model)
    moved = [j for j, channel in enumerate(model["inputs"])
             if channel.get("role") != "disturbance"]
    sizes = [0.0 if j in moved else
             0.5 / max(abs(row[j] / step) for row, step in zip(matrix, steps))
             for j in range(len(matrix[0]))]
    square = [[row[j] for j in moved] for row in matrix]
    for i, step in enumerate(steps):
        right = [step if r == i else 0.0 for r in range(len(steps))]
        for j, u in zip(moved, solve(square, right)):
            sizes[j] = max(sizes[j], abs(u))
    return sizes


def times_of(element):
    """The sum of the time constants of an element."""
    if "gain" in element:
        return element.get("time_constant", 0.0)
    return element["denominator"][-2] / element["denominator"][-1]


def product(a, b):
    result = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result


def with_factor(element, numerator, denominator):
    """The element times a rational function of s."""
    result = {key: element[key] for key in ("output", "input", "delay")}
    result["numerator"] = product(
        element.get("numerator", [element.get("gain")]), numerator)
    result["denominator"] = product(
        element.get("denominator", [element.get("time_constant"), 1.0]), denominator)
    return result


def aged(element, gain=1.0, time_constant=1.0, delay=0.0):
    """The element with its gain and time constants times factors and a longer dead time."""
    result = copy.deepcopy(element)
    result["delay"] = max(0.0, result["delay"] + delay)
    if "gain" in result:
        result["gain"] *= gain
        if "time_constant" in result:  # not of an integrator alone
            result["time_constant"] *= time_constant
        return result
    for key, factor in (("numerator", gain), ("denominator", 1.0)):
        order = len(result[key]) - 1
        result[key] = [factor * value * math.pow(time_constant, order - i)
                       for i, value in enumerate(result[key])]
    return result


def lagged(elements, output, lag):
    return [with_factor(element, [1.0], [lag, 1.0]) if element["output"] == output
            else element for element in elements]
