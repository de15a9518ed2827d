"""Records of real plants: every model corrected from every record, and judged on the others.

A folder has pairs NAME.json (the model that was in the controller) and NAME.csv (the record).
A model is judged on each record that had no part in its correction: the fit in per cent of each
output as its step responses simulate it from the recorded inputs, from the first sample to the
last, without the mean, compared at every tenth sample; and the errors of predictions 60 and 300
samples ahead (what is measured now, and what the inputs do until then by the step responses).
"""

import csv
import itertools
import math
import operator


def names(folder):
    if not folder.is_dir():
        return []
    return sorted(file.stem for file in folder.glob("*.json")
                  if file.with_suffix(".csv").exists())


def pairs(folder):
    """(model, record)."""
    return list(itertools.product(names(folder), repeat=2))


def read_columns(file):
    with file.open(newline="") as stream:
        rows = csv.reader(stream)
        header = next(rows)
        columns = list(zip(*rows))
    return {name: [float(value) if value else math.nan for value in column]
            for name, column in zip(header, columns)}


STRIDE = 10  # samples from one that is compared to the next
AHEAD = (60, 300)  # samples


def simulate(impulse, inputs, samples):
    """The response to the inputs less their first values, both held from sample to sample."""
    result = [0.0] * len(range(0, samples, STRIDE))
    for name, weights in impulse.items():
        moves = [value - inputs[name][0] for value in inputs[name]]
        reversed_weights = weights[::-1]
        length = len(weights)
        padded = [0.0] * length + moves
        for i, k in enumerate(range(0, samples, STRIDE)):
            # weights[i] is for the input held i + 1 samples ago.
            result[i] += sum(map(operator.mul, reversed_weights, padded[k:k + length]))
    return result


def fit(measured, simulated):
    """100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖), means removed."""
    errors = [y - x for y, x in zip(measured, simulated) if not math.isnan(y)]
    values = [y for y in measured if not math.isnan(y)]

    def norm(signal):
        mean = sum(signal) / len(signal)
        return math.sqrt(sum((value - mean) ** 2 for value in signal))

    return 100.0 * (1.0 - norm(errors) / norm(values))


def ahead(measured, simulated, steps):
    """Root mean square of (y(k + h) − y(k)) − (ŷ(k + h) − ŷ(k))."""
    errors = [y - x for y, x in zip(measured, simulated)]
    moves = [late - early for early, late in zip(errors, errors[steps:])
             if not math.isnan(late - early)]
    return math.sqrt(sum(move * move for move in moves) / len(moves))


def impulses(responses, output, which):
    """Differences of the step responses `OUTPUT/INPUT which`."""
    result = {}
    for name, response in responses.items():
        pair, _, kind = name.rpartition(" ")
        if kind == which and pair.startswith(f"{output}/"):
            result[pair[len(output) + 1:]] = [
                after - before for before, after in zip(response, response[1:])]
    return result


def judge(responses, record, output, which):
    """The fit, and the error of each horizon in AHEAD."""
    measured = record[output][::STRIDE]
    simulated = simulate(impulses(responses, output, which), record, len(record["time"]))
    return fit(measured, simulated), [
        ahead(measured, simulated, horizon // STRIDE) for horizon in AHEAD]


def run(arguments, correct, model, record, scratch):
    folder = arguments.hardware
    sample_times = read_columns(folder / f"{record}.csv")["time"][:2]
    figures, result = correct(arguments, scratch, folder / f"{model}.json",
                              folder / f"{record}.csv")
    if result is None or figures["decision"] != "corrected":
        return figures
    responses = read_columns(scratch / "out" / "step_response.csv")
    times = responses["time"]
    if not math.isclose(times[1] - times[0], sample_times[1] - sample_times[0], rel_tol=1e-6):
        figures["reason"] += " (responses not at the record's sample time: not judged)"
        return figures
    falls = []
    for other in names(folder):
        if other == record:
            continue
        unseen = read_columns(folder / f"{other}.csv")
        for channel in result["residuals"]["initial"]:
            output = channel["output"]
            before, errors_before = judge(responses, unseen, output, "initial")
            after, errors_after = judge(responses, unseen, output, "corrected")
            falls.append(before - after)
            for horizon, *errors in zip(AHEAD, errors_before, errors_after):
                figures.setdefault("ahead", []).append(
                    [other, output, horizon, *(round(error, 4) for error in errors)])
            figures.setdefault("fits", []).append([other, output, round(before, 2),
                                                   round(after, 2)])
    figures["worst_fall"] = max(falls)
    return figures
