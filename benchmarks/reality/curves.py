"""What is true of the curves of a trial, and how near the curves of a result are to it."""

import math


def true_gain(trial, channel, is_output):
    """The gain at a value of the channel relative to that where the record began, as a function;
    None of a channel that is straight, or bent otherwise than these."""
    if is_output:
        sensor = trial.output(channel).get("sensor", {})
        a = sensor.get("curvature", 0.0)
        # φ'(p) at the p that shows y.
        slopes = {"logarithm": lambda y: math.exp(-a * y),
                  "quadratic": lambda y: math.sqrt(max(1.0 + 4.0 * a * y, 1e-12)),
                  "tanh": lambda y: 1.0 - (a * y) ** 2}
        return slopes.get(sensor.get("curve")) if a else None
    actuator = trial.input(channel).get("actuator", {})
    rangeability = actuator.get("rangeability", 1.0)
    if rangeability > 1.0:
        return lambda u: rangeability ** (u / actuator["span"])
    if "kink" in actuator:
        return lambda u: actuator["kink_slope"] if u > actuator["kink"] else 1.0
    return None


def integral(points, slope):
    """∫ slope by the trapezoidal rule, at every point."""
    values = [0.0]
    for (a, one), (b, other) in zip(points, points[1:]):
        values.append(values[-1] + 0.5 * (slope(one) + slope(other)) * (b - a))
    return values


def judged(trial, result):
    """Columns: curves that are true and told, their largest error over what was visited as a
    share of it, points of their bands, and those that hold the truth; curves told that are not."""
    row = {}
    if trial.plant.simulated:
        return row  # every channel of these is bent, in a way of its own
    for curve in (result or {}).get("curves", []):
        gain = true_gain(trial, curve["channel"], curve["is_output"])
        if gain is None:
            row["curves_false"] = row.get("curves_false", 0) + 1
            continue
        points = curve["gains"]
        truth = [gain(point["value"]) / gain(curve["at"]) for point in points]
        # Of an output the curve is z over y, whose slope is one by the gain.
        power = -1.0 if curve["is_output"] else 1.0
        true_curve = integral(list(zip([p["value"] for p in points], truth)),
                              lambda g: max(g, 1e-6) ** power)
        told = integral([(p["value"], p["gain"]) for p in points], lambda g: g ** power)
        # Both have the value 0 where the record began.
        begin = min(range(len(points)), key=lambda k: abs(points[k]["value"] - curve["at"]))
        error = max(abs((a - told[begin]) - (b - true_curve[begin]))
                    for a, b in zip(told, true_curve)) / true_curve[-1]
        row["curve_error"] = max(row.get("curve_error", 0.0), error)
        row["curve_points"] = row.get("curve_points", 0) + len(points)
        row["curve_inside"] = row.get("curve_inside", 0) + sum(
            p["lower"] <= g <= p["upper"] for p, g in zip(points, truth))
    return row
