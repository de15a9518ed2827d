"""plant_model_ratio.py FOLDER: detection by the plant-model ratio.

Selvanathan and Tangirala, Ind. Eng. Chem. Res. 49 (2010) 4210: the ratio of the frequency
responses of plant and model, from cross-spectra with the set points r,

    R_ij(ω) = [Φ_yr Φ_ur⁻¹]_ij / [Φ_ŷr Φ_ur⁻¹]_ij,   ŷ the model's outputs,

is 1 where they agree. Signals are differences from sample to sample, so that steps end; spectra are
sums over the lowest BINS frequencies for each set point. A pair is wrong if |R − 1| is above
THRESHOLD and the pair makes more than a tenth of its output. Without set points it cannot tell.
"""

import sys

import common
import numpy as np
import responses

BINS = 2  # for each set point
THRESHOLD = 0.2


def spectra(given, names, columns):
    """Fourier transforms of differences, at the lowest frequencies of all stretches."""
    count = BINS * max(1, len(given.set_points))
    parts = []
    for stretch, values in zip(given.stretches, columns):
        parts.append(np.array([np.fft.rfft(np.diff(values[name]))[1:count + 1]
                               for name in names]))
    return np.hstack(parts)


def held_over(values):
    """Unknown values are those before."""
    known = np.flatnonzero(np.isfinite(values))
    return values[known[np.maximum(np.searchsorted(known, np.arange(len(values)), "right") - 1, 0)]]


def ratios(given):
    """R of every pair and the weight of its input's part in the model's output; None where set
    points do not tell inputs apart."""
    if len(given.set_points) < len(given.inputs):
        return None
    measured, modelled = [], []
    for stretch in given.stretches:
        simulated = responses.simulate(given.model["elements"], stretch)
        measured.append({**stretch.columns, **{
            name: held_over(stretch.columns[name]) for name in given.outputs}})
        modelled.append({name: simulated.get(name, np.zeros(len(stretch.time)))
                         for name in given.outputs})
    points = spectra(given, given.set_points, measured).conj().T
    inputs = spectra(given, given.inputs, measured) @ points
    if np.linalg.matrix_rank(inputs, tol=1e-6 * np.linalg.norm(inputs, 2)) < len(given.inputs):
        return None
    backwards = np.linalg.pinv(inputs)
    plant = spectra(given, given.outputs, measured) @ points @ backwards
    model = spectra(given, given.outputs, modelled) @ points @ backwards
    sizes = np.array([np.sqrt(sum(np.var(columns[name]) for columns in measured))
                      for name in given.inputs])
    parts = np.abs(model) * sizes
    with np.errstate(divide="ignore", invalid="ignore"):
        return plant / model, parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-300)


def main(folder):
    given = common.Given(folder)
    found = ratios(given)
    if found is None:
        given.leave("cannot_tell")
        return
    aged = [(output, name) for output, some, weights in zip(given.outputs, *found)
            for name, ratio, weight in zip(given.inputs, some, weights)
            if weight > 0.1 and abs(ratio - 1.0) > THRESHOLD]
    given.leave("mismatch" if aged else "no_change", aged=aged)


if __name__ == "__main__":
    main(sys.argv[1])
