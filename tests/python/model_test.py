"""Process models: made, written, and given to other packages."""

import pickle

import numpy as np
import pytest

import mle


def test_from_fopdt_is_the_closed_form():
    model = mle.from_fopdt([[2.0, 0.0], [-1.0, 3.0]], [[5.0, 1.0], [10.0, 4.0]], 2.0)
    assert model.outputs == ["y1", "y2"] and model.inputs == ["u1", "u2"]
    assert model.time_unit == "min"
    response = model.step_response(0.5, 101)
    assert response.shape == (101, 2, 2)
    t = 0.5 * np.arange(101)
    rise = np.where(t > 2.0, 1 - np.exp(-(t - 2.0) / 5.0), 0.0)
    np.testing.assert_allclose(response[:, 0, 0], 2.0 * rise, atol=1e-12)
    assert not response[:, 0, 1].any()
    np.testing.assert_array_equal(model.static_gains, [[2.0, 0.0], [-1.0, 3.0]])
    assert model.settling_time == pytest.approx(2.0 + 5 * 10.0)
    with pytest.raises(ValueError):
        response[0, 0, 0] = 1.0  # a view that may not be written to


def test_labels_and_integrators():
    """A data frame of gains names the channels; an integrator's response is a ramp."""
    pd = pytest.importorskip("pandas")
    gain = pd.DataFrame([[0.1, 2.0]], index=["level"], columns=["inlet", "heat"])
    model = mle.from_fopdt(gain, 5.0, 1.0, integrating=[[True, False]])
    assert (model.inputs, model.outputs) == (["inlet", "heat"], ["level"])
    ramp = model.step_response(1.0, 201)[:, 0, 0]
    assert np.diff(ramp)[-1] == pytest.approx(0.1) and ramp[-1] == pytest.approx(0.1 * (200 - 6))
    with pytest.raises(ValueError, match=r"integrating has the shape \(1,\)"):
        mle.from_fopdt(gain, 5.0, integrating=[True])


def test_json_round_trip_and_equality(configs):
    model = mle.ProcessModel.read(configs / "dryer.json")
    again = mle.ProcessModel.from_json(model.to_json())
    assert again == model and hash(again) == hash(model)
    assert pickle.loads(pickle.dumps(model)) == model
    assert model != mle.ProcessModel.read(configs / "dryer_aged.json")
    assert model.input_roles.count("disturbance") == 1
    assert "dryer" in repr(model).lower()


def test_names_units_and_disturbances():
    model = mle.from_fopdt(
        [[1.0, 0.5]],
        3.0,
        inputs=["steam", "feed"],
        outputs=["temperature"],
        input_units=["t/h", "t/h"],
        output_units=["°C"],
        disturbances=["feed"],
        time_unit="s",
        name="heater",
    )
    assert model.input_roles == ["manipulated", "disturbance"]
    assert model.output_units == ["°C"] and model.name == "heater"
    assert model.time_unit == "s"


def test_what_is_wrong_with_a_model():
    with pytest.raises(ValueError, match=r"gain has the shape \(2,\)"):
        mle.from_fopdt([1.0, 2.0], 3.0)
    with pytest.raises(ValueError, match=r"time_constant has the shape \(1, 2\)"):
        mle.from_fopdt([[1.0]], [[3.0, 4.0]])
    with pytest.raises(ValueError, match="delay must be finite"):
        mle.from_fopdt([[1.0]], 3.0, np.nan)
    with pytest.raises(mle.InvalidInputError, match="delay"):
        mle.from_fopdt([[1.0]], 3.0, -1.0)
    with pytest.raises(mle.InvalidInputError, match="pole"):
        mle.from_transfer_functions([[[1.0]]], [[[1.0, -1.0]]])
    with pytest.raises(ValueError, match="2 are needed"):
        mle.from_fopdt([[1.0, 1.0]], 3.0, inputs=["a"])
    with pytest.raises(ValueError, match="not inputs"):
        mle.from_fopdt([[1.0]], 3.0, disturbances=["feed"])
    with pytest.raises(mle.InvalidInputError, match="my model"):
        mle.ProcessModel.from_json("{", "my model")
    with pytest.raises(IndexError):
        mle.from_fopdt([[1.0]], 3.0).element(1, 0)
    with pytest.raises(ValueError):
        mle.from_fopdt([[1.0]], 3.0).step_response(0.1, 0)
    with pytest.raises(ValueError):
        mle.from_fopdt([[1.0]], 3.0).step_response(-0.1, 10)


class System:
    """What scipy.signal and python-control have in common."""

    def __init__(self, num, den, dt=None):
        self.num, self.den, self.dt = num, den, dt


def test_state_spaces_beyond_double():
    for a, b in ((np.diag([-1e200, -1e200]), 1.0), (-np.eye(2), 1e200)):
        with pytest.raises(ValueError, match="beyond 1.8e308"):
            mle.from_state_space(a, np.full((2, 1), b), np.full((1, 2), b))


def test_what_is_no_system():
    for systems in ("abc", [["x"]], [[1.0, object()]]):
        with pytest.raises(TypeError, match="a system must be .*; this is (str|object)"):
            mle.from_systems(systems)
    for systems in (3.0, [1.0]):
        with pytest.raises(TypeError, match="systems must be a system, or a table of such; this is"):
            mle.from_systems(systems)


def test_systems_of_other_packages():
    single = mle.from_systems(System(np.array([2.0]), np.array([5.0, 1.0])), 1.5)
    assert single == mle.from_transfer_functions([[[2.0]]], [[[5.0, 1.0]]], 1.5)
    table = [[System([1.0], [3.0, 1.0]), None], [0.5, System([[[2.0]]], [[[4.0, 1.0]]])]]
    model = mle.from_systems(table, inputs=["a", "b"], outputs=["c", "d"])
    np.testing.assert_array_equal(model.static_gains, [[1.0, 0.0], [0.5, 2.0]])
    # python-control's kind: a table of coefficients, and labels.
    matrix = System(
        [[np.array([1.0]), np.array([0.0])], [np.array([3.0]), np.array([2.0, 1.0])]],
        [[np.array([2.0, 1.0])] * 2, [np.array([6.0, 5.0, 1.0])] * 2],
        0,
    )
    matrix.input_labels, matrix.output_labels = ["p", "q"], ["r", "s"]
    model = mle.from_systems(matrix, [[0.0, 0.0], [1.0, 2.0]])
    assert model.inputs == ["p", "q"] and model.outputs == ["r", "s"]
    assert model.element(1, 1) == ([2.0, 1.0], [6.0, 5.0, 1.0], 2.0)
    with pytest.raises(ValueError, match="discrete"):
        mle.from_systems(System([1.0], [1.0, -0.5], 0.1))


def test_scipy_in_and_out():
    signal = pytest.importorskip("scipy.signal")
    model = mle.from_systems(signal.TransferFunction([1.0, 4.0], [2.0, 3.0, 1.0]), 0.5)
    systems, delays = mle.to_scipy(model)
    assert delays.tolist() == [[0.5]]
    times, response = signal.step(systems[0][0], T=np.linspace(0, 10, 51))
    shifted = mle.from_systems(systems).step_response(0.2, 51)[:, 0, 0]
    np.testing.assert_allclose(shifted, response, atol=1e-9)
    of_states = mle.from_systems([[systems[0][0].to_ss()]])
    np.testing.assert_allclose(of_states.static_gains, [[4.0]])


def test_systems_in_a_table_keep_all_they_have():
    signal = pytest.importorskip("scipy.signal")
    # y[k] = 0.9 y[k-1] + 0.1 u[k-3]: a lag, and two samples of dead time more.
    delayed = signal.StateSpace(
        [[0.9, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0], [1.0], [0.0]],
        [[0.1, 0.0, 0.0]],
        [[0.0]],
        dt=1.0,
    )
    alone = mle.from_systems(delayed)
    assert alone.element(0, 0)[2] == pytest.approx(2.0)
    table = mle.from_systems([[delayed, 0.5]], delays=[[1.0, 4.0]])
    assert table.element(0, 0)[:2] == alone.element(0, 0)[:2]
    assert table.element(0, 0)[2] == alone.element(0, 0)[2] + 1.0
    assert table.element(0, 1)[2] == 4.0
    two = signal.StateSpace(-np.eye(2), np.eye(2), np.eye(2), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="one input and one output; this has 2 inputs and 2"):
        mle.from_systems([[two]])


def test_control_in_and_out():
    control = pytest.importorskip("control")
    model = mle.from_fopdt([[2.0]], 5.0)
    np.testing.assert_allclose(control.dcgain(mle.to_control(model)), 2.0)
    assert mle.from_systems(mle.to_control(model)) == model


@pytest.mark.parametrize("kind", [kind for kind in vars(mle._mle).values() if isinstance(kind, type)])
def test_objects_made_without_init_are_refused(kind):
    """Their memory would be read before it is written."""
    unmade = kind.__new__(kind)
    properties = [name for name, value in vars(kind).items() if isinstance(value, property) and name[0] != "_"]
    assert properties
    for name in properties:
        with pytest.raises(TypeError, match="without __init__"):
            getattr(unmade, name)


def test_transforms_and_the_linear_model_at_a_point():
    text = """{"name": "heater", "time_unit": "min",
      "inputs": [{"name": "valve", "unit": "%", "transform": {
        "kind": "equal_percentage", "rangeability": 50, "closed": 0, "open": 100, "at": 40}}],
      "outputs": [{"name": "flow", "unit": "m3/h"}],
      "elements": [{"output": "flow", "input": "valve",
                    "gain": 0.5, "time_constant": 5, "delay": 2}]}"""
    model = mle.ProcessModel.from_json(text)
    assert model.transforms == {"valve": {"kind": "equal_percentage", "rangeability": 50,
                                          "closed": 0, "open": 100, "at": 40}}
    open_ = model.linear_at({"valve": 100.0})
    assert open_.transforms == {}
    assert open_.static_gains[0, 0] == pytest.approx(0.5 * 50.0 ** 0.6)
    assert model.linear_at({}).static_gains[0, 0] == 0.5
    with pytest.raises(ValueError, match="no channel 'flap'"):
        model.linear_at({"flap": 1.0})
