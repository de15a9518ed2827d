"""octave.py arx|n4sid FOLDER: identification from scratch by Octave's control package.

octave_peers.m, the best of five orders by simulation of held-out blocks; step
responses are replaced by the nearest of first order with dead time. Every output must be measured
in every sample. There is no test: it always corrects.
"""

import pathlib
import subprocess
import sys

import common
import kernel
import numpy as np


def main(method, folder):
    given = common.Given(folder)
    windows, stride = kernel.thinned(given)
    p, m = len(given.outputs), len(given.inputs)
    if not all(np.isfinite(window).all() for window in windows):
        given.leave("cannot_tell")
        return
    samples = max(10, given.settling() // stride)
    scratch = pathlib.Path(folder, "octave")
    scratch.mkdir()
    for number, window in enumerate(windows, 1):
        window[:, :p] -= window[:3, :p].mean(axis=0)
        np.savetxt(scratch / f"window_{number}.txt", window, fmt="%.12g")
    block = max(10, max(len(window) for window in windows) // 16)
    (scratch / "settings.txt").write_text(f"{p} {m} {samples} {block}\n")
    subprocess.run(["octave-cli", "--norc", pathlib.Path(__file__).with_name("octave_peers.m"),
                    scratch, method], check=True)
    rows = np.loadtxt(scratch / "step.txt", ndmin=2)
    steps = {(output, name): rows[:, i * m + j] for i, output in enumerate(given.outputs)
             for j, name in enumerate(given.inputs)}
    given.interval *= stride
    if not all(np.isfinite(step).all() for step in steps.values()):
        given.leave("cannot_tell")
        return
    given.leave("corrected", common.of_steps(given, steps))


if __name__ == "__main__":
    main(*sys.argv[1:])
