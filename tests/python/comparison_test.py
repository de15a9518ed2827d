"""Predictions, fits, residuals, responses: what models say of records."""

import inspect
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

import mle


@pytest.fixture(scope="module")
def example():
    return mle.load_example("column")


def fit(measured, predicted):
    known = np.isfinite(predicted) & np.isfinite(measured)
    y, e = measured[known], (measured - predicted)[known]
    return 100 * (1 - np.linalg.norm(e) / np.linalg.norm(y - y.mean()))


def test_fits_of_simulations(example):
    """The aged plant, whose noise is small, fits well; the old model does not."""
    compared = mle.compare(example.records, example.model, example.plant)
    assert list(compared.fits.columns) == ["column", "aged column"]
    assert list(compared.fits.index) == ["overhead", "bottoms"]
    assert (compared.fits["aged column"] > 90).all()
    assert (compared.fits["column"] < compared.fits["aged column"]).all()
    (measured,) = compared.measured
    (predicted,) = compared.predicted["aged column"]
    assert fit(measured.bottoms.values, predicted.bottoms.values) == pytest.approx(
        compared.fits.loc["bottoms", "aged column"]
    )
    assert predicted.index.equals(measured.index) and measured.index.equals(example.records.index)
    assert "aged column" in str(compared) and "<table" in compared._repr_html_()


def test_simulation_is_that_of_the_inputs(example):
    """Free simulation is lsim() of the inputs but for a constant."""
    inputs = example.records[["reflux", "steam"]]
    response = mle.lsim(example.plant, inputs)
    simulated = mle.predict(example.records, example.plant, horizon=None)
    difference = (simulated - response).dropna()
    assert len(difference) > 500
    np.testing.assert_allclose(difference - difference.iloc[0], 0.0, atol=1e-9)
    measured = example.records[["overhead", "bottoms"]]
    assert (measured - simulated).mean().abs().max() < 1e-9


def test_shorter_horizons_predict_better(example):
    errors = [
        (example.records.bottoms - mle.predict(example.records, example.model, h).bottoms).std()
        for h in (1, 10, None)
    ]
    assert errors[0] < errors[1] < errors[2]
    with pytest.raises(ValueError, match="horizon = -1"):
        mle.predict(example.records, example.model, -1)


def test_channels_go_by_name(example):
    mixed = example.records[["steam", "bottoms", "reflux", "overhead"]]
    fits = mle.compare(mixed, example.plant).fits
    assert fits.equals(mle.compare(example.records, example.plant).fits)
    other = mle.from_fopdt(
        pd.DataFrame(
            [[-9.7, 6.6], [-9.45, 12.8]], ["bottoms", "overhead"], ["steam", "reflux"]
        ),
        [[14.4, 10.9], [21, 16.7]],
        [[3, 7], [3, 1]],
        name="aged column",
    )
    turned = mle.compare(example.records, example.plant, other).fits
    np.testing.assert_allclose(turned["aged column"], turned["aged column (2)"], atol=1e-6)


def test_several_records(loop):
    model, plant, record = loop
    compared = mle.compare([record, record], plant)
    assert len(compared.measured) == 2
    one = mle.compare(record, plant).fits
    np.testing.assert_allclose(compared.fits, one, atol=1e-6)
    assert len(mle.predict([record, record], plant)) == 2


def test_missing_inputs_are_not_predicted(example):
    frame = example.records.copy()
    frame.loc[frame.index[400:420], "steam"] = np.nan
    predicted = mle.predict(frame, example.plant, max_gap=0)
    assert predicted.iloc[402:418].isna().all().all()
    assert predicted.iloc[300:395].notna().all().all()


def test_residuals(example):
    right = mle.resid(example.records, example.plant)
    wrong = mle.resid(example.records, example.model)
    assert right.p_values.loc["bottoms", "steam"] > wrong.p_values.loc["bottoms", "steam"]
    assert wrong.p_values.loc["bottoms", "steam"] < 1e-3
    lags = right.cross_correlation.index
    assert lags.min() == -lags.max() and right.autocorrelation.index[0] == 1
    outside = right.autocorrelation.abs() > right.autocorrelation_limits
    assert outside.mean().max() < 0.1
    assert len(mle.resid(example.records, example.plant, 7).autocorrelation) == 7
    with pytest.raises(ValueError, match="max_lag = 0"):
        mle.resid(example.records, example.plant, 0)
    assert "bottoms" in str(right) and "<table" in right._repr_html_()


def test_response_of_arrays():
    model = mle.from_fopdt([[2.0]], 10.0, 3.0)
    steps = mle.lsim(model, np.ones(40), 1.0)
    np.testing.assert_allclose(steps[:, 0], model.step_response(1.0, 40)[:, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(steps, mle.lsim(model, np.ones((40, 1)), np.arange(40)))
    seconds = mle.from_fopdt([[2.0]], 600.0, 180.0, time_unit="s", inputs=["u"])
    index = pd.date_range("2024-03-04", periods=40, freq="min")
    np.testing.assert_allclose(
        mle.lsim(seconds, pd.DataFrame({"u": 1.0}, index)).to_numpy(), steps, atol=1e-12
    )
    ramp = mle.from_fopdt([[0.5]], 0.0, integrating=True)
    np.testing.assert_allclose(mle.lsim(ramp, np.ones(5), 1.0)[:, 0], 0.5 * np.arange(5))
    for call, match in (
        (lambda: mle.lsim(model, np.ones((5, 2)), 1.0), "U has 2 columns, the model 1"),
        (lambda: mle.lsim(model, np.ones(5), [0, 1, 3, 4, 5]), "evenly spaced"),
        (lambda: mle.lsim(model, pd.DataFrame({"v": [1.0]})), "no column 'u1'"),
    ):
        with pytest.raises(ValueError, match=match):
            call()


def test_advice(example, frame, loop):
    advice = mle.advice(example.records, example.model)
    assert advice.obstacle == "" and set(advice.elements.state) == {"informed"}
    assert (advice.elements.gain_error < 0.1).all()
    assert advice.feedback == {"overhead": True, "bottoms": True}
    assert "Standard errors that a correction may expect" in str(advice)
    # Steps by hand: no input answers to the output.
    model = loop[0]
    noise = np.random.default_rng(5).normal(size=600) * 0.01
    inputs = np.where(np.arange(600) // 100 % 2 == 0, 0.0, 1.0)
    steps = pd.DataFrame(
        {"level": mle.lsim(model, inputs, 1.0)[:, 0] + noise, "valve": inputs},
        pd.Index(np.arange(600.0), name="time"),
    )
    assert mle.advice(steps, model).feedback == {"level": False}
    # Tags in other units: nothing could be corrected, and why.
    frame["level"] *= -1.0
    frame["level_setpoint"] *= -1.0
    turned = mle.advice(frame, model)
    assert turned.obstacle and turned.obstacle in str(turned)


def test_records_come_first(example):
    for function in (mle.compare, mle.predict, mle.resid, mle.advice):
        with pytest.raises(TypeError, match="the records come first"):
            function(example.model, example.records)
    with pytest.raises(TypeError, match="at least one model"):
        mle.compare(example.records)


def test_figures(example):
    pytest.importorskip("matplotlib")
    from matplotlib import pyplot

    compared = mle.compare(example.records, example.model, example.plant)
    assert len(compared.plot().axes) == 2
    assert len(mle.resid(example.records, example.model).plot().axes) == 6
    figure, axes = pyplot.subplots(2, 1)
    assert compared.plot(axes) is figure
    pyplot.close("all")


def test_keywords_are_complete(example):
    """Notebooks complete what a signature names; checkers know its types."""
    named = inspect.signature(mle.correct).parameters
    assert "response_horizon" in named and "options" not in named
    assert named["confidence"].default == "0.95"
    assert "sample_time" in inspect.signature(mle.compare).parameters
    assert "setpoints" in inspect.signature(mle.simulate).parameters
    from mle.keywords import CorrectOptions

    assert set(CorrectOptions.__annotations__) < set(named)


def test_examples_are_the_same_each_time(example):
    assert mle.load_example("column").records.equals(example.records)
    heaters = mle.load_example("heaters")
    assert heaters.model.time_unit == "s" and len(heaters.records) > 1000
    result = mle.correct(heaters.model, heaters.records)
    assert result.decision == "corrected"
    changed = result.elements.aged
    assert changed.loc[("T2", "Q2")] and not changed.loc[("T1", "Q1")]
    with pytest.raises(ValueError, match="there are column, heaters"):
        mle.load_example("furnace")


class System:
    """What python-control's systems and responses look like."""

    def __init__(self, **attributes):
        self.__dict__.update(attributes)


def test_systems_of_other_packages_are_models(loop):
    model, _, record = loop
    system = System(
        num=[[[2.0]]], den=[[[10.0, 1.0]]], dt=0, input_labels=["valve"], output_labels=["level"]
    )
    same = mle.from_fopdt([[2.0]], 10.0, inputs=["valve"], outputs=["level"])
    assert mle.compare(record, system).fits.equals(mle.compare(record, same).fits)
    np.testing.assert_array_equal(
        mle.lsim(system, np.ones(20), 1.0), mle.lsim(same, np.ones(20), 1.0)
    )
    response = System(
        time=record.start_time + record.sample_time * np.arange(len(record)),
        outputs=record.outputs[:, 0],
        inputs=record.inputs.T,
        output_labels=["level"],
        input_labels=["valve"],
    )
    read = mle.read_records(response, model)[0]
    np.testing.assert_array_equal(read.outputs, record.outputs)
    np.testing.assert_array_equal(read.inputs, record.inputs)


def test_the_real_package(loop):
    control = pytest.importorskip("control")
    if not hasattr(control, "TransferFunction"):
        pytest.skip("another thing of this name")
    model, _, record = loop
    system = control.TransferFunction([2.0], [10.0, 1.0], inputs=["valve"], outputs=["level"])
    same = mle.from_fopdt([[2.0]], 10.0, inputs=["valve"], outputs=["level"])
    assert mle.compare(record, system).fits.equals(mle.compare(record, same).fits)
    response = mle.to_time_response(record, model)
    again = mle.read_records(response, model)[0]
    np.testing.assert_array_equal(again.outputs, record.outputs)


def test_types_of_keywords_are_up_to_date(source):
    made = subprocess.run(
        [sys.executable, source / "scripts" / "python_keywords"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert made == (source / "python" / "mle" / "keywords.py").read_text(encoding="utf-8")
