"""The same numbers as the command's, to the last digit, of files and of frames."""

import json

import numpy as np
import pandas as pd
import pytest

import mle

# What tells how a result was asked for, and of what bytes.
OF_THE_CALL = {"command", "flags", "inputs"}


def numbers(result):
    return {key: value for key, value in result.items() if key not in OF_THE_CALL}


def read(path, **options):
    return pd.read_csv(path, float_precision="round_trip", **options)


@pytest.fixture(scope="module")
def column(configs, tmp_path_factory):
    """Wood and Berry's column after its gains have changed."""
    model = mle.ProcessModel.read(configs / "wood_berry.json")
    record = mle.simulate(
        model,
        mle.ProcessModel.read(configs / "wood_berry_gain.json"),
        setpoints=[("overhead", 100, 1), ("bottoms", 250, 1)],
        duration=400,
        sample_time=1,
        seed=1,
    )
    path = tmp_path_factory.mktemp("column") / "run.csv"
    mle.to_dataframe(record, model).to_csv(path)
    return configs / "wood_berry.json", path


@pytest.fixture(scope="module")
def dryer(configs, tmp_path_factory):
    """With a measured disturbance, and lost samples of inputs and outputs."""
    model = mle.ProcessModel.read(configs / "dryer.json")
    record = mle.simulate(
        model,
        mle.ProcessModel.read(configs / "dryer_aged.json"),
        sample_time=10,
        control_period=20,
        output_weight=[10, 0.1],
        move_weight=[0.1, 1, 1],
        duration=4000,
        setpoints=[("product moisture", 1000, -0.5), ("exhaust temperature", 2500, 4)],
        disturbance_variance=[0, 0, 0.1],
        disturbance_time_constant=200,
        lost_probability=0.01,
    )
    path = tmp_path_factory.mktemp("dryer") / "run.csv"
    frame = mle.to_dataframe(record, model)
    frame.iloc[50:53, list(frame.columns).index("burner")] = np.nan
    frame.iloc[300:310, :1] = np.nan
    frame.to_csv(path)
    return configs / "dryer.json", path


@pytest.fixture(scope="module")
def export(loop, tmp_path_factory):
    """As a historian of another country writes it, with tags of its own."""
    model, _, record = loop
    frame = mle.to_dataframe(record, model, start="2024-03-04 06:00")
    frame.columns = ["LI101", "SP101", "FC201"]
    frame["LI101"] = frame["LI101"] + 3.4
    frame.index = frame.index.strftime("%d.%m.%Y %H:%M:%S")
    folder = tmp_path_factory.mktemp("export")
    frame.to_csv(folder / "run.csv", sep=";", decimal=",")
    (folder / "model.json").write_text(model.to_json())
    return folder / "model.json", folder / "run.csv"


TAGS = {"LI101": "level*1-3.4", "SP101": "level_setpoint", "FC201": "valve"}
EXPORT_OPTIONS = {"tags": TAGS, "time_format": "day_first", "estimator": "output_error"}


def test_column_equals_the_command(column, run_correct):
    model, path = column
    expected = run_correct(model, path)
    of_file = mle.correct(model, path)
    assert numbers(of_file.to_dict()) == numbers(expected)
    # The whole of result.json, but for what was called.
    ours, theirs = of_file.to_dict(), dict(expected)
    assert ours["inputs"] == theirs["inputs"]
    assert ours["command"].startswith("mle.correct(")
    theirs["flags"]["figures"] = "true"
    assert ours["flags"] == theirs["flags"]
    of_frame = mle.correct(mle.ProcessModel.read(model), read(path))
    assert numbers(of_frame.to_dict()) == numbers(expected)
    assert expected["decision"] == "corrected"


def test_dryer_with_lost_samples_equals_the_command(dryer, run_correct):
    model, path = dryer
    expected = run_correct(model, path, "--estimator=output_error")
    frame = read(path)
    assert frame.isna().sum().sum() > 10
    result = mle.correct(model, frame.set_index("time"), estimator="output_error")
    assert numbers(result.to_dict()) == numbers(expected)


def test_export_equals_the_command(export, run_correct):
    model, path = export
    tags = ",".join(f"{tag}={channel}" for tag, channel in TAGS.items())
    expected = run_correct(
        model, path, "--estimator=output_error", "--time_format=day_first", f"--tags={tags}"
    )
    result = mle.correct(model, path, **EXPORT_OPTIONS)
    assert numbers(result.to_dict()) == numbers(expected)
    # As a frame the notes have no words on how the text was read.
    frame = read(path, sep=";", decimal=",", index_col="time")
    frame.index = pd.to_datetime(frame.index, format="%d.%m.%Y %H:%M:%S")
    of_frame = mle.correct(model, frame, tags=TAGS, estimator="output_error").to_dict()
    for key in set(numbers(expected)) - {"notes"}:
        assert of_frame[key] == expected[key], key


def test_records_of_files_and_frames_are_the_same(dryer):
    model = mle.ProcessModel.read(dryer[0])
    for options in ({}, {"sample_time": 30}, {"sample_time": 4}, {"max_gap": 0}):
        of_file = mle.read_records(dryer[1], model, **options)
        of_frame = mle.read_records(read(dryer[1]), model, **options)
        assert len(of_file) == len(of_frame) > 0
        for a, b in zip(of_file, of_frame):
            assert (a.start_time, a.sample_time) == (b.start_time, b.sample_time)
            assert a.outputs.tobytes() == b.outputs.tobytes()
            assert a.inputs.tobytes() == b.inputs.tobytes()
            assert a.set_points.tobytes() == b.set_points.tobytes()


def test_uneven_rows_are_resampled_as_those_of_a_file(loop, tmp_path):
    model, _, record = loop
    frame = mle.to_dataframe(record, model).reset_index()
    frame["time"] += 0.3 * (frame.index % 3 == 1)
    frame = frame.drop(index=range(150, 175))
    frame.to_csv(tmp_path / "uneven.csv", index=False)
    of_file = mle.read_records(tmp_path / "uneven.csv", model, sample_time=2)
    of_frame = mle.read_records(frame, model, sample_time=2)
    assert len(of_file) == len(of_frame) == 2
    for a, b in zip(of_file, of_frame):
        assert a.start_time == b.start_time
        assert a.outputs.tobytes() == b.outputs.tobytes()
        assert a.inputs.tobytes() == b.inputs.tobytes()


def test_result_json_is_what_the_schema_wants(loop, frame):
    jsonschema = pytest.importorskip("jsonschema")
    import os
    import pathlib

    schemas = pathlib.Path(os.environ["MLE_SOURCE"]) / "docs" / "schemas"
    result = mle.correct(loop[0], frame, estimator="output_error")
    jsonschema.validate(
        json.loads(result.to_json()), json.loads((schemas / "result.schema.json").read_text())
    )
    assert result.to_dict()["inputs"]["data"][0]["path"] == "data frame"
