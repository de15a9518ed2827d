"""loop_autocovariance.py FOLDER: detection by the autocovariance of the loop as designed.

It is told the control law and the variance of the noise (loop.json): the loop of the model, under
the set points of the record, is simulated LOOPS times. The autocovariances of control errors of an
output, at lags of 0, 1/8 and 1/4 of the settling time, differ from those of the record if one is
further from their mean than Student's t allows at LEVEL, for all outputs and lags together (after
Wang, Simkoff, Baldea, Chiang, Castillo, Bindlish and Stanley, Systems & Control Letters 104, 2017,
5, who estimate the mismatch from them). Which element is wrong is not told.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import common
import numpy as np

LOOPS = 12
BOUND = 5.5  # of t with 11 degrees of freedom: some 0.02 %, for some tens of tests


def covariances(given, stretches):
    """Of each output and lag, a row."""
    lags = [0, given.settling() // 8, given.settling() // 4]
    result = []
    for output in given.outputs:
        errors = [stretch.columns[output] - stretch.columns[f"{output}_setpoint"]
                  for stretch in stretches]
        for lag in lags:
            products = common.rows_of([error[:len(error) - lag] * error[lag:] for error in errors])
            result.append(products.mean() if len(products) else 0.0)
    return np.array(result)


def set_points(given):
    """The changes of the record, as the flag has them."""
    parts = []
    (stretch,) = given.stretches
    for output in given.outputs:
        values = stretch.columns[f"{output}_setpoint"]
        for k in np.flatnonzero(np.diff(values, prepend=0.0)):
            parts.append(f"{output}:{stretch.time[k]:.10g}:{values[k]:.10g}")
    return ",".join(parts)


def designed(given, loop, scratch):
    flags = [f"--{name}={value}" for name, value in loop["flags"].items()]
    folder = pathlib.Path(scratch)
    (folder / "model.json").write_text(json.dumps(given.model))
    (folder / "effects.json").write_text(json.dumps({"outputs": [
        {"name": name, "sensor": {"noise_variance": variance}}
        for name, variance in loop["noise_variance"].items()]}))
    rows = []
    for seed in range(1, LOOPS + 1):
        subprocess.run([pathlib.Path(os.environ["MLE_APPS"], "mle_simulate"),
                        f"--model={folder}/model.json", f"--setpoints={set_points(given)}",
                        f"--duration={given.stretches[0].time[-1]:.10g}", f"--seed={seed}",
                        f"--out={folder}/record.csv", f"--effects={folder}/effects.json",
                        "--noise_variance=0", *flags], check=True,
                       stdout=subprocess.DEVNULL)
        other = common.Given(folder)
        rows.append(covariances(given, other.stretches))
    return np.array(rows)


def main(folder):
    given = common.Given(folder)
    loop = json.loads((given.folder / "loop.json").read_text())
    if not loop or len(given.stretches) != 1 or len(given.set_points) < len(given.outputs):
        given.leave("cannot_tell")
        return
    with tempfile.TemporaryDirectory() as scratch:
        rows = designed(given, loop, scratch)
    spread = rows.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / LOOPS)
    far = np.abs(covariances(given, given.stretches) - rows.mean(axis=0)) > BOUND * spread
    given.leave("mismatch" if far.any() else "no_change")


if __name__ == "__main__":
    main(sys.argv[1])
