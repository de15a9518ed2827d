"""Trials of a model beside the one in use."""

import numpy as np
import pytest

import mle

NAMES = {"inputs": ["valve"], "outputs": ["level"]}
TUNING = {"sample_time": 1.0, "control_period": 2, "noise_variance": 1e-4}


def record_of(model, plant, seed, changes=4):
    """From rest; the set point goes up and down. Noise is known after some settling
    times (52 min) of rest."""
    steps = [("level", 600 + 120 * i, float(i % 2 == 0)) for i in range(changes)]
    return mle.simulate(
        model, plant, setpoints=steps, duration=600 + 120 * changes, seed=seed, **TUNING
    )


@pytest.fixture(scope="module")
def models():
    return (
        mle.from_fopdt([[2.0]], 10.0, 2.0, **NAMES),
        mle.from_fopdt([[1.6]], 10.0, 2.0, **NAMES),
    )


def test_right_model_is_adopted_and_rolled_back_where_the_plant_returns(models):
    in_use, plant = models
    trial = mle.Trial(in_use, plant, sample_time=1.0)
    assert trial.advice == "wait" and trial.changes == 0 and len(trial.evidence) == 0
    trial.learn(record_of(in_use, plant, 1))
    assert trial.look(record_of(in_use, plant, 2)) == "adopt"
    assert trial.changes == 4
    assert trial.left_share < 0.05
    evidence = trial.evidence
    assert list(evidence.columns) == ["for", "against"]
    assert evidence["for"].iloc[-1] > np.log(100)
    trial.adopt()
    assert trial.advice == "keep"
    assert trial.look(record_of(plant, in_use, 3)) == "roll_back"


def test_wrong_model_is_dropped_from_data_frames_too(models):
    in_use, plant = models
    opposite = mle.from_fopdt([[2.4]], 10.0, 2.0, **NAMES)
    trial = mle.Trial(in_use, opposite, sample_time=1.0)
    trial.learn(record_of(in_use, plant, 1))
    frame = mle.to_dataframe(record_of(in_use, plant, 2), in_use, start="2026-01-01")
    assert trial.look(frame) == "drop"


def test_says_what_is_wrong(models):
    in_use, plant = models
    with pytest.raises(mle.InvalidInputError, match="level is 2; it must be in"):
        mle.Trial(in_use, plant, 1.0, level=2)
    with pytest.raises(mle.InvalidInputError, match="is the model in use"):
        mle.Trial(in_use, in_use, 1.0)
    with pytest.raises(mle.InvalidInputError, match="sample time of the record is 1"):
        mle.Trial(in_use, plant, 2.0).look(record_of(in_use, plant, 1))
