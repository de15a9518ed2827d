"""Step responses, state spaces, and systems of other packages, in and out."""

import json
import pickle

import numpy as np
import pytest

import mle

NAMES = {"inputs": ["a", "b"], "outputs": ["c", "d"]}


def column():
    """Two by two, one element zero, dead times of whole minutes."""
    gain = [[2.0, 0.0], [-1.0, 3.0]]
    return mle.from_fopdt(gain, [[5.0, 1.0], [10.0, 4.0]], [[2, 0], [1, 3]], **NAMES)


def steps_of(model, dt=1.0, samples=80):
    return model.step_response(dt, samples + 1)[1:]


def test_step_responses_in_and_out():
    coefficients = steps_of(column())
    steps = mle.from_step_responses(
        coefficients, 1.0, **NAMES, disturbances=["b"], output_units=["m", "K"], name="tank"
    )
    np.testing.assert_array_equal(steps.coefficients, coefficients)
    assert (len(steps), steps.dt, steps.time_unit) == (80, 1.0, "min")
    assert steps.inputs == ["a", "b"] and steps.output_units == ["m", "K"]
    assert steps.input_roles == ["manipulated", "disturbance"] and steps.name == "tank"
    np.testing.assert_allclose(steps.process.static_gains, column().static_gains, atol=1e-5)
    difference = abs(steps_of(steps.process) - coefficients).max(axis=0)
    ranges = abs(coefficients).max(axis=0) + (coefficients == 0).all(axis=0)
    np.testing.assert_allclose(steps.differences, difference / ranges, atol=1e-12)
    assert steps.differences.max() < 0.002
    for again in (
        mle.StepResponseModel.from_json(steps.to_json()),
        mle.StepResponseModel.from_json(steps.to_csv()),
        pickle.loads(pickle.dumps(steps)),
    ):
        assert again == steps and hash(again) == hash(steps)
        np.testing.assert_array_equal(again.coefficients, coefficients)
    assert "80 coefficients every 1 min" in repr(steps)


def test_step_responses_of_files(configs, tmp_path):
    steps = mle.StepResponseModel.read(configs / "wood_berry.csv")
    truth = mle.ProcessModel.read(configs / "wood_berry.json")
    np.testing.assert_allclose(steps.process.static_gains, truth.static_gains, rtol=1e-3)
    assert mle.ProcessModel.read(configs / "wood_berry.csv") == steps.process
    with pytest.raises(ValueError, match="not step responses; mle.ProcessModel reads it"):
        mle.StepResponseModel.read(configs / "wood_berry.json")


def test_what_is_wrong_with_step_responses():
    good = steps_of(column())
    for coefficients, match in (
        (good[:, :, 0], r"shape \(80, 2\); it must be \(coefficients, outputs, inputs\)"),
        (good[:5], "10"),
        (np.where(np.arange(80)[:, None, None] == 3, np.nan, good), r"\[3, 0, 0\] is nan"),
    ):
        with pytest.raises(ValueError, match=match):
            mle.from_step_responses(coefficients, 1.0, **NAMES)
    with pytest.raises(mle.InvalidInputError, match="interval"):
        mle.from_step_responses(good, 0.0, **NAMES)
    noise = np.random.default_rng(1).normal(size=(60, 1, 1))
    with pytest.raises(mle.InvalidInputError, match="% of its range"):
        mle.from_step_responses(noise, 1.0)


def test_corrected_model_is_of_the_kind_given(loop, tmp_path):
    model, _, record = loop
    steps = mle.from_step_responses(
        steps_of(model, samples=60), 1.0, inputs=["valve"], outputs=["level"]
    )
    result = mle.correct(steps, record, estimator="output_error")
    assert result.decision == "corrected"
    corrected = result.corrected
    assert isinstance(corrected, mle.StepResponseModel) and len(corrected) == 60
    change = steps_of(result.process, samples=60) - steps_of(steps.process, samples=60)
    np.testing.assert_allclose(
        corrected.coefficients, steps.coefficients + change, rtol=0, atol=1e-12
    )
    assert corrected.process == result.process
    result.write(tmp_path)
    assert mle.StepResponseModel.read(tmp_path / "model_corrected.json") == corrected
    again = pickle.loads(pickle.dumps(result))
    assert again.corrected == corrected and again.corrected.process == result.process
    # And of a file: the numbers that the command writes.
    (tmp_path / "steps.csv").write_text(steps.to_csv())
    of_file = mle.correct(tmp_path / "steps.csv", record, estimator="output_error")
    np.testing.assert_array_equal(of_file.corrected.coefficients, corrected.coefficients)
    # What comes out goes into all that takes a model.
    assert mle.Mpc(corrected).gain.shape == mle.Mpc(result.process).gain.shape
    mle.Mpc(model).exchange_model(corrected)
    assert len(mle.simulate(corrected, result.process, duration=20, sample_time=1)) == 21


def state_space(**options):
    a = np.array([[0.9, 0.1], [0.0, 0.8]])
    b, c = np.array([[0.0], [0.5]]), np.array([[1.0, 0.0]])
    return mle.StateSpaceModel(a, b, c, dt=1.0, **options)


def test_state_space_of_arrays():
    system = state_space(inputs=["u"], outputs=["y"], input_delays=[3], output_delays=[1])
    np.testing.assert_array_equal(system.A, [[0.9, 0.1], [0.0, 0.8]])
    np.testing.assert_array_equal(system.D, [[0.0]])
    assert system.input_delays == [3] and system.output_delays == [1] and system.dt == 1.0
    assert mle.StateSpaceModel.from_json(system.to_json()) == system
    assert pickle.loads(pickle.dumps(system)) == system
    assert "2 states" in repr(system)
    # What describes it: 0.05 z^-1 / ((z - 0.9)(z - 0.8)), four samples late.
    response = np.zeros(101)
    x = np.zeros(2)
    for k in range(97):
        response[k + 4] = x[0]
        x = system.A @ x + system.B[:, 0]
    described = system.process.step_response(1.0, 101)[:, 0, 0]
    np.testing.assert_allclose(described, response, atol=0.002 * response.max())


def test_disturbance_model_of_a_state_space():
    system = state_space()
    assert system.disturbance_model is None
    content = json.loads(system.to_json())
    content["disturbance_model"] = {"A": [[1.0]], "C": [[1.0]], "K": [[0.25]], "Q": [[0.01]],
                                    "R": [0.1]}
    disturbed = mle.StateSpaceModel.from_json(json.dumps(content))
    A, C, K, Q, R = disturbed.disturbance_model
    assert A.shape == C.shape == Q.shape == (1, 1) and R.shape == (1,) and K[0, 0] == 0.25
    assert disturbed != system and pickle.loads(pickle.dumps(disturbed)) == disturbed
    content["disturbance_model"]["K"] = [[-0.25]]
    with pytest.raises(mle.InvalidInputError, match="disturbance_model: A − K C"):
        mle.StateSpaceModel.from_json(json.dumps(content))


def test_what_is_wrong_with_a_state_space():
    b, c = np.ones((2, 1)), np.ones((1, 2))
    with pytest.raises(ValueError, match=r"A has the shape \(2,\); it must be a matrix"):
        mle.StateSpaceModel([0.5, 0.5], b, c, dt=1)
    with pytest.raises(mle.InvalidInputError, match="B is 2 × 1, must be 3 × 1"):
        mle.StateSpaceModel(0.5 * np.eye(3), b, np.ones((1, 3)), dt=1)
    with pytest.raises(mle.InvalidInputError, match="unit circle|stable"):
        mle.StateSpaceModel(1.1 * np.eye(2), b, c, dt=1)
    with pytest.raises(mle.InvalidInputError, match="sample_time"):
        mle.StateSpaceModel(0.5 * np.eye(2), b, c, dt=0)
    for text in ({"name": b"\xff"}, {"inputs": [b"\xff"]}, {"time_unit": 3}):
        with pytest.raises(TypeError):
            mle.StateSpaceModel(0.5 * np.eye(2), b, c, dt=1, **text)
    with pytest.raises(mle.InvalidInputError, match="D must be zero"):
        mle.StateSpaceModel(0.5 * np.eye(2), b, c, [[1.0]], dt=1).process


def test_state_spaces_are_models(loop):
    """Of the loop's model in discrete time, its exact realisation."""
    model, _, record = loop
    pole = np.exp(-1.0 / 10.0)
    system = mle.StateSpaceModel(
        [[pole]], [[1.0]], [[2.0 * (1 - pole)]], dt=1, inputs=["valve"], outputs=["level"],
        input_delays=[2],
    )
    numerator, denominator, delay = system.process.element(0, 0)
    assert (numerator[0], denominator[0], delay) == pytest.approx((2.0, 10.0, 2.0), rel=1e-6)
    result = mle.correct(system, record, estimator="output_error")
    assert result.decision == "corrected"
    # Given back as such: its state stands first, and what has changed below it.
    corrected = result.corrected
    assert isinstance(corrected, mle.StateSpaceModel)
    assert (corrected.dt, corrected.inputs, corrected.outputs) == (1.0, ["valve"], ["level"])
    assert corrected.A.shape[0] > 1 and corrected.A[0, 0] == system.A[0, 0]
    np.testing.assert_allclose(
        corrected.process.step_response(1.0, 81), result.process.step_response(1.0, 81),
        atol=0.01 * abs(result.process.static_gains).max(),
    )
    files = result._files
    assert mle.StateSpaceModel.from_json(files["model_corrected.json"]) == corrected
    assert pickle.loads(pickle.dumps(result)).corrected == corrected
    # Nothing has changed: to the last bit what was given.
    unchanged = mle.correct(corrected, record, estimator="output_error")
    assert unchanged.decision == "no_change" and unchanged.corrected == corrected
    with pytest.raises(TypeError, match="a model must be mle.ProcessModel.* this is int"):
        mle.correct(3, record)


def test_continuous_state_space():
    """Elements keep their own states alone, whatever the basis."""
    poles = np.array([0.2, 0.1, 0.25])
    turn = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, -0.3], [0.2, 0.0, 1.0]])
    a = turn @ np.diag(-poles) @ np.linalg.inv(turn)
    b = turn @ np.array([[0.4, 0.0], [0.1, 0.0], [0.0, 0.75]])
    c = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]]) @ np.linalg.inv(turn)
    model = mle.from_state_space(a, b, c, delays=1.5, **NAMES)
    expected = mle.from_fopdt(
        [[2.0, 0.0], [-1.0, 3.0]], [[5.0, 1.0], [10.0, 4.0]], 1.5, **NAMES
    )
    np.testing.assert_allclose(steps_of(model), steps_of(expected), atol=1e-9)
    assert [len(model.element(i, j)[1]) for i, j in ((0, 0), (1, 0), (1, 1))] == [2, 2, 2]
    with pytest.raises(ValueError, match=r"C has the shape \(2, 2\); it must be \(2, 3\)"):
        mle.from_state_space(a, b, np.eye(2))
    with pytest.raises(mle.InvalidInputError, match="pole"):
        mle.from_state_space([[0.1]], [[1.0]], [[1.0]])
    # A direct term, and complex poles.
    lively = mle.from_state_space([[0, 1], [-1, -0.4]], [[0], [1]], [[1, 0]], [[0.5]])
    np.testing.assert_allclose(lively.static_gains, [[1.5]])
    assert len(lively.element(0, 0)[1]) == 3


class System:
    """What python-control's systems look like."""

    def __init__(self, **attributes):
        self.dt = 0
        self.__dict__.update(attributes)


def test_state_spaces_of_other_packages():
    system = System(
        A=np.array([[-0.2]]), B=np.array([[0.4]]), C=np.array([[1.0]]), D=np.array([[0.0]]),
        input_labels=["u[0]"], output_labels=["y[0]"],
    )
    model = mle.from_systems(system, 2.0)
    assert model.inputs == ["u[0]"] and model.element(0, 0)[2] == 2.0
    np.testing.assert_allclose(model.static_gains, [[2.0]])
    system.dt = 0.5
    system.A = np.array([[np.exp(-0.1)]])
    system.B = np.array([[2.0 * (1 - np.exp(-0.1))]])
    np.testing.assert_allclose(mle.from_systems(system).static_gains, [[2.0]], rtol=1e-6)
    with pytest.raises(ValueError, match="arguments of mle.StateSpaceModel"):
        mle.from_systems(system, 2.0)
    system.dt = True
    with pytest.raises(ValueError, match="without a sample time"):
        mle.from_systems(system)


def test_scipy_state_spaces_in_and_out():
    signal = pytest.importorskip("scipy.signal")
    system = state_space(input_delays=[3], output_delays=[2])
    out = mle.to_scipy(system)
    assert out.dt == 1.0 and out.A.shape == (7, 7)
    _, response = signal.dstep(out, n=40)
    described = system.process.step_response(1.0, 40)[:, 0, 0]
    np.testing.assert_allclose(response[0][:, 0], described, atol=0.01)
    assert not response[0][:6, 0].any() and response[0][7, 0] > 0.0
    # And back: the same responses, with states in place of dead times.
    back = mle.StateSpaceModel(out.A, out.B, out.C, out.D, dt=out.dt)
    _, again = signal.dstep(mle.to_scipy(back), n=40)
    np.testing.assert_allclose(again[0], response[0], atol=1e-14)
    continuous = signal.StateSpace([[-0.2]], [[0.4]], [[1.0]], [[0.0]])
    for given in (continuous, continuous.to_zpk(), [[continuous]]):
        np.testing.assert_allclose(mle.from_systems(given).static_gains, [[2.0]])
    sampled = continuous.to_discrete(0.5)
    np.testing.assert_allclose(mle.from_systems(sampled).static_gains, [[2.0]], rtol=1e-6)
    with pytest.raises(ValueError, match="is discrete .dt = 0.5."):
        mle.from_systems(sampled.to_tf())
