#!/usr/bin/env python3
"""method.py FOLDER: a method in Python, without any package.

It corrects gains of the elements from the ends of the record: of each output the largest change of
its own first input says what the gain is. Not a good method; a short one.

    benchmarks/suite/run --method='mine=benchmarks/suite/examples/method.py'
"""

import csv
import json
import pathlib
import sys

folder = pathlib.Path(sys.argv[1])
model = json.loads((folder / "model.json").read_text())
with (folder / "record.csv").open(newline="") as file:
    rows = list(csv.DictReader(file))


def mean(name, part):
    """Of the values that are known in a part of the record."""
    values = [float(row[name]) for row in part if row[name] not in ("", "nan")]
    return sum(values) / len(values) if values else 0.0


def gain(element):
    if "gain" in element:
        return element["gain"]
    return element["numerator"][-1] / element["denominator"][-1]


tenth = len(rows) // 10
begin, end = rows[:tenth], rows[-tenth:]
decision = [["no_change"]]
for output in [channel["name"] for channel in model["outputs"]]:
    row = [element for element in model["elements"] if element["output"] == output]
    moves = [gain(e) * (mean(e["input"], end) - mean(e["input"], begin)) for e in row]
    largest = max(range(len(row)), key=lambda i: abs(moves[i]), default=None)
    if largest is None or abs(moves[largest]) < 1e-9 or "gain" not in row[largest]:
        continue
    missing = mean(output, end) - mean(output, begin) - sum(moves)
    factor = 1.0 + missing / moves[largest]
    if 0.3 < factor < 3.0 and abs(factor - 1.0) > 0.1:
        row[largest]["gain"] *= factor
        decision[0] = ["corrected"]
        decision.append(["aged", output, row[largest]["input"]])
(folder / "model.json").write_text(json.dumps(model))
with (folder / "decision.txt").open("w", newline="") as file:
    csv.writer(file).writerows(decision)
