"""Simulation and the predictive controller."""

import numpy as np
import pytest

import mle


def test_simulate_is_the_command(loop, tmp_path):
    import subprocess

    from conftest import COMMANDS

    model, plant, record = loop
    (tmp_path / "model.json").write_text(model.to_json())
    (tmp_path / "plant.json").write_text(plant.to_json())
    subprocess.run(
        [COMMANDS / "mle_simulate"]
        + [f"--model={tmp_path}/model.json", f"--plant={tmp_path}/plant.json"]
        + ["--setpoints=level:60:1,level:180:-0.5", "--duration=300", "--sample_time=1"]
        + ["--control_period=2", "--noise_variance=1e-4", "--seed=3"]
        + [f"--out={tmp_path}/run.csv"],
        check=True,
        capture_output=True,
    )
    read = mle.read_records(tmp_path / "run.csv", model)[0]
    assert read.outputs.tobytes() == record.outputs.tobytes()
    assert read.inputs.tobytes() == record.inputs.tobytes()


def test_loop_closed_by_hand_is_that_of_simulate(loop):
    """Plant and Mpc, stepped in Python, against simulate() without noise."""
    model, plant, _ = loop
    tuning = {"control_period": 2, "prediction_horizon": 20, "control_horizon": 4}
    whole = mle.simulate(
        model,
        plant,
        setpoints=[("level", 10, 1.0)],
        duration=60,
        sample_time=1,
        noise_variance=0,
        **tuning,
    )
    mpc = mle.Mpc(model, **tuning)
    process = mle.Plant(plant, sample_time=1.0)
    outputs, inputs, next_input = [], [], np.zeros(1)
    for k in range(61):
        if k % 2 == 0:
            held, next_input = next_input, mpc.step(process.outputs, [1.0 if k >= 10 else 0.0])
        outputs.append(process.outputs)
        inputs.append(held)
        process.advance(held)
    np.testing.assert_allclose(np.array(outputs), whole.outputs, atol=1e-12)
    np.testing.assert_allclose(np.array(inputs), whole.inputs, atol=1e-12)
    assert whole.outputs[-1, 0] == pytest.approx(1.0, abs=0.02)


def test_controller_in_python_closes_the_loop(loop):
    model, plant, _ = loop

    class Integral:
        def __init__(self):
            self.value = 0.0

        def __call__(self, measured, set_points, last):
            self.value += 0.05 * (set_points[0] - measured[0])
            return [self.value]

    record = mle.simulate(
        model,
        plant,
        controller=Integral(),
        setpoints=[("level", 0, 1.0)],
        duration=400,
        sample_time=1,
        noise_variance=0,
    )
    assert record.outputs[-1, 0] == pytest.approx(1.0, abs=1e-3)
    with pytest.raises(ValueError, match=r"shape \(2,\); it must be \(1,\)"):
        mle.simulate(model, plant, controller=lambda y, r, u: [1.0, 2.0])
    with pytest.raises(ZeroDivisionError):
        mle.simulate(model, plant, controller=lambda y, r, u: 1 / 0)


def test_limits_and_exchange_of_the_model(loop):
    model, plant, _ = loop
    mpc = mle.Mpc(model, control_period=2, max_move=0.05, max_input=[0.2])
    process = mle.Plant(plant, sample_time=2.0)
    last = np.zeros(1)
    for _ in range(20):
        u = mpc.step(process.outputs, [5.0])
        assert abs(u[0] - last[0]) <= 0.05 + 1e-9 and u[0] <= 0.2 + 1e-9
        process.advance(last)
        last = u
    before = mpc.predicted_outputs
    mpc.exchange_model(plant)
    np.testing.assert_allclose(mpc.predicted_outputs, before)
    with pytest.raises(mle.InvalidInputError):
        mpc.exchange_model(mle.from_fopdt([[1.0, 1.0]], 5.0))
    with pytest.raises(mle.InvalidInputError, match="control_period"):
        mpc.exchange_model(plant, control_period=3)


def test_what_is_wrong(loop):
    model, plant, _ = loop
    with pytest.raises(TypeError, match="Mpc.. got an unexpected keyword argument"):
        mle.Mpc(model, horizon=3)
    with pytest.raises(mle.InvalidInputError, match="^prediction_horizon=0: it must be"):
        mle.Mpc(model, prediction_horizon=0)
    with pytest.raises(ValueError, match=r"measured has the shape \(2,\); it must be \(1,\)"):
        mle.Mpc(model).step([1.0, 2.0], [1.0])
    with pytest.raises(mle.InvalidInputError, match="nothing"):
        mle.simulate(model, plant, setpoints=[("nothing", 1, 2)])
    with pytest.raises(mle.InvalidInputError, match="plant"):
        mle.simulate(model, mle.from_fopdt([[1.0]], 5.0))
    with pytest.raises(mle.NotUsableError, match="diverge|beyond|grow"):
        mle.simulate(
            model,
            mle.from_fopdt([[-20.0]], 10.0, 2.0, inputs=["valve"], outputs=["level"]),
            setpoints=[("level", 1, 1.0)],
        )


def test_frame_of_a_record(loop):
    model, _, record = loop
    frame = mle.to_dataframe(record, model)
    assert list(frame.columns) == ["level", "level_setpoint", "valve"]
    assert frame.index[-1] == 300.0 and len(frame) == len(record)
    dated = mle.to_dataframe(record, model, start="2024-03-04 06:00")
    assert str(dated.index[1]) == "2024-03-04 06:01:00"
