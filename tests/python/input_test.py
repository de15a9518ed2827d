"""What is wrong with the input is an exception that says what, and where."""

import sqlite3

import numpy as np
import pandas as pd
import pytest

import mle
from mle.options import text_of

FAST = {"estimator": "output_error"}


def refused(match, kind=mle.InvalidInputError):
    return pytest.raises(kind, match=match)


def test_names_the_missing_and_the_unknown_column(loop, frame):
    with refused(r"no column 'level' \(nearest: 'levle'\)"):
        mle.correct(loop[0], frame.rename(columns={"level": "levle"}))
    frame["other"] = 1.0
    with refused("'other' is neither") as caught:
        mle.correct(loop[0], frame)
    assert "ignore_other_columns" in caught.value.options
    assert mle.correct(loop[0], frame, ignore_other_columns=True, **FAST).decision == "corrected"


def test_shapes_that_do_not_agree():
    with refused("outputs has the shape", ValueError):
        mle.Record(np.zeros(10), np.zeros((10, 1)), sample_time=1.0)
    with refused("samples"):
        mle.Record(np.zeros((10, 1)), np.zeros((9, 1)), sample_time=1.0)
    with refused("sample_time|Δt"):
        mle.Record(np.zeros((10, 1)), np.zeros((10, 1)), sample_time=0.0)


def test_masked_samples_are_bad_ones():
    samples = np.arange(20.0).reshape(10, 2)
    masked = np.ma.array(samples, mask=samples > 16.5)
    record = mle.Record(masked, np.ma.array(samples), masked, sample_time=1.0)
    wanted = np.where(samples > 16.5, np.nan, samples)
    np.testing.assert_array_equal(record.outputs, wanted)
    np.testing.assert_array_equal(record.set_points, wanted)
    np.testing.assert_array_equal(record.inputs, samples)
    with refused("outputs has complex samples", ValueError):
        mle.Record(1j * samples, samples, sample_time=1.0)
    gains = np.ma.array([[1.0, 1e20]], mask=[[False, True]])
    with refused("gains? has masked entries", ValueError):
        mle.from_fopdt(gains, 5.0, 1.0)


def test_columns_of_packed_rows(loop, frame):
    packed = np.zeros(
        len(frame), dtype=[("count", "i4")] + [(name, "f8") for name in frame.columns]
    )
    for name in frame.columns:
        packed[name] = frame[name]
    views = pd.concat(
        [pd.Series(packed[name], index=frame.index, name=name, copy=False) for name in frame],
        axis=1,
        copy=False,
    )
    ours, theirs = (mle.read_records(table, loop[0])[0] for table in (views, frame))
    np.testing.assert_array_equal(ours.outputs, theirs.outputs)
    np.testing.assert_array_equal(ours.inputs, theirs.inputs)


def test_record_of_another_model(loop):
    record = mle.Record(np.zeros((50, 2)), np.zeros((50, 1)), np.zeros((50, 2)), sample_time=1.0)
    with refused("2 outputs and 1 inputs; the model has 1 and 1"):
        mle.correct(loop[0], record)


def test_column_of_nothing_but_nan(loop, frame):
    frame["valve"] = np.nan
    with refused("'valve' has no good sample in any row .0 empty, 301 NaN"):
        mle.correct(loop[0], frame)


def test_infinite_sample(loop, frame):
    frame.iloc[6, frame.columns.get_loc("level")] = np.inf
    with refused("data frame: row 7, column 'level': inf is not a finite number"):
        mle.correct(loop[0], frame)


def test_object_column(loop, frame):
    frame["level"] = frame["level"].astype(object)
    with refused("column 'level' holds object; it must hold numbers"):
        mle.correct(loop[0], frame)


def test_index_without_times(loop, frame):
    with refused("its index counts rows, and it has no column 'time'"):
        mle.correct(loop[0], frame.reset_index(drop=True))
    frame.index = [f"row {k}" for k in range(len(frame))]
    with refused("its times are of the type object"):
        mle.correct(loop[0], frame)


def test_column_of_dates(loop, frame):
    """Whatever it is called, as exports have it; text has to become dates."""
    expected = mle.read_records(frame, loop[0])[0]
    plain = frame.reset_index().rename(columns={"time": "Timestamp"})
    record = mle.read_records(plain, loop[0])[0]
    assert record.outputs.tobytes() == expected.outputs.tobytes()
    plain["Timestamp"] = plain["Timestamp"].astype(str)
    with refused(r"set_index\(pandas.to_datetime\(frame\['Timestamp'\]\)\)"):
        mle.correct(loop[0], plain)


def test_series(loop, frame):
    with refused("a Series is one channel", TypeError):
        mle.correct(loop[0], frame["level"])


def test_index_that_does_not_increase(loop, frame):
    swapped = frame.iloc[[0, 1, 3, 2, *range(4, len(frame))]]
    with refused("data frame: row 4: time 2024-03-04 06:02 follows 2024-03-04 06:03") as caught:
        mle.correct(loop[0], swapped)
    assert caught.value.options == ("skip_backward_times",)
    with refused(r"follows .*: sort the rows \(a data frame by sort_index\(\)\)"):
        mle.correct(loop[0], frame.iloc[::-1])
    with refused("row 3: time 2024-03-04 06:01 is duplicated"):
        mle.correct(loop[0], frame.iloc[[0, 1, 1, *range(2, len(frame))]])
    with refused("a time is missing"):
        index = frame.index.to_series()
        index.iloc[3] = pd.NaT
        mle.correct(loop[0], frame.set_index(pd.DatetimeIndex(index)))


def test_one_row(loop, frame):
    with refused("data frame has 1 rows; a record needs at least 2"):
        mle.correct(loop[0], frame.iloc[:1])
    with refused("data frame has 0 rows"):
        mle.correct(loop[0], frame.iloc[:0])
    with refused("no records"):
        mle.correct(loop[0], [])


def test_zones(loop, frame):
    """Aware and naive frames are the same record; a mixture is refused."""
    naive = mle.correct(loop[0], frame, **FAST)
    aware = mle.correct(loop[0], frame.tz_localize("Europe/Berlin"), **FAST)
    declared = mle.correct(loop[0], frame, time_zone="Europe/Berlin", **FAST)
    assert naive.p_value == aware.p_value == declared.p_value
    begin = [r.to_dict()["windows"][0]["from_date"] for r in (naive, aware, declared)]
    assert begin[0].endswith("+00:00") and begin[1].endswith("+01:00")
    assert begin[1] == begin[2]
    assert begin[0][:19] == begin[1][:19]
    with refused("some of the data frames have a time zone"):
        mle.correct(loop[0], [frame, frame.tz_localize("UTC")])


def test_hour_that_clocks_show_twice(loop, frame):
    """An aware index goes on where the clocks go back."""
    index = pd.date_range("2024-10-27 00:30", periods=len(frame), freq="min", tz="Europe/Berlin")
    result = mle.correct(loop[0], frame.set_index(index), **FAST)
    assert result.p_value == mle.correct(loop[0], frame, **FAST).p_value


def test_times_that_are_not_in_the_zone(loop, frame):
    local = {"time_zone": "Europe/Berlin"}
    for begin, time in (("2024-03-31 00:30", "2024-03-31 02:00"), ("2024-10-27 00:30", "02:00")):
        index = pd.date_range(begin, periods=len(frame), freq="min")
        with refused(f"not all of its times can be times in Europe/Berlin: .*{time}") as caught:
            mle.correct(loop[0], frame.set_index(index), **local)
        assert caught.value.options == ("time_zone",)
    with refused("there is no time zone 'Europe/Berlim'"):
        mle.correct(loop[0], frame, time_zone="Europe/Berlim")


def test_several_frames_are_one_record(loop, frame):
    whole = mle.read_records(frame, loop[0])
    parts = mle.read_records([frame.iloc[:90], frame.iloc[90:]], loop[0])
    assert len(parts) == 1
    assert parts[0].outputs.tobytes() == whole[0].outputs.tobytes()


def test_frames_of_other_layouts(loop, frame):
    """Float32, integers, nullable numbers, single blocks and slices are read."""
    expected = mle.read_records(frame, loop[0])[0]
    for other in (
        frame.copy().astype({"level_setpoint": "Float64"}),
        frame[["valve", "level_setpoint", "level"]],
        pd.concat([frame[[c]] for c in frame], axis=1),
        pd.DataFrame(np.asfortranarray(frame.values), frame.index, frame.columns),
        pd.DataFrame(np.repeat(frame.values, 2, axis=0), columns=frame.columns)
        .iloc[::2]
        .set_index(frame.index),
    ):
        record = mle.read_records(other, loop[0])[0]
        assert record.outputs.tobytes() == expected.outputs.tobytes()
        assert record.inputs.tobytes() == expected.inputs.tobytes()
    single = mle.read_records(frame.astype("float32"), loop[0])[0]
    np.testing.assert_allclose(single.outputs, expected.outputs, rtol=1e-6, atol=1e-6)


def test_options(loop, frame):
    with pytest.raises(TypeError, match="keyword argument 'estimatr'; did you mean 'estimator'"):
        mle.correct(loop[0], frame, estimatr="arx")
    with refused("^estimator=other: choose from"):
        mle.correct(loop[0], frame, estimator="other")
    with refused("^confidence=2: it must be"):
        mle.correct(loop[0], frame, confidence=2)
    with refused("^validation_folds=many: it must be a whole number"):
        mle.correct(loop[0], frame, validation_folds="many")
    with refused("separator: this option is for files"):
        mle.correct(loop[0], frame, separator="tab")
    with refused("max_gap: this option is not for mle.Record"):
        mle.correct(loop[0], loop[2], max_gap=3)
    listed = mle.correct_options()
    assert "  confidence [0.95] in (0, 1)\n" in listed and "dry_run" not in listed


def test_files(loop, tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere.csv"):
        mle.correct(loop[0], tmp_path / "nowhere.csv")
    with pytest.raises(FileNotFoundError, match="nowhere.json"):
        mle.correct(tmp_path / "nowhere.json", tmp_path / "nowhere.csv")
    (tmp_path / "bad.csv").write_text("time,level,valve\n0,1,2\n1,one,2\n")
    with refused("bad.csv: line 3, column 2"):
        mle.correct(loop[0], tmp_path / "bad.csv")
    with pytest.raises(TypeError, match="these are int"):
        mle.correct(loop[0], [1])


def test_paths_that_are_none(loop):
    with pytest.raises(ValueError, match="NUL"):
        mle.correct("model\0.json", loop[2])
    with pytest.raises(ValueError, match="NUL"):
        mle.ProcessModel.read("model\0.json")
    with pytest.raises(ValueError, match="surrogates"):
        mle.Plant("model\ud800.json", sample_time=1.0)
    with pytest.raises(TypeError, match="int"):
        mle.StepResponseModel.read(3)


def test_messages_that_are_not_utf_8():
    """This one quotes half a character."""
    with refused("model.json: line 1, column 10: .*\ufffd"):
        mle.ProcessModel.from_json('{"name": é}', "model.json")


def test_frames_of_records(loop):
    model, _, record = loop
    with pytest.raises(TypeError, match="record must be mle.Record; this is int"):
        mle.to_dataframe(3, model)
    with pytest.raises(TypeError, match="a model must be .*; this is float"):
        mle.to_dataframe(record, 2.0)
    with pytest.raises(ValueError, match="the record has 1 outputs; the model has 2"):
        mle.to_dataframe(record, mle.from_fopdt([[1.0], [2.0]], 10.0))


def test_sample_times_without_a_rate():
    steps = 1.0 - np.exp(-np.arange(1, 31) / 5.0)[:, None, None]
    with refused(r"interval is 1e-310, must be in \[1e-300, 1e\+300\]"):
        mle.from_step_responses(steps, 1e-310)
    with pytest.raises(ValueError, match="at most 1e8 values"):
        mle.from_fopdt([[1.0, 2.0], [3.0, 4.0]], 5.0).step_response(1e-5, 2**29)


def test_nothing_to_learn(loop, frame):
    with refused("no set point changes") as caught:
        mle.correct(loop[0], frame.assign(level_setpoint=0.0, valve=1.0))
    assert caught.value.code == "INVALID_ARGUMENT"
    assert caught.value.options == ("change_times", "tags")


def test_frames_of_a_database(loop, frame):
    """pandas reads what a historian's database has, in wide and in long tables."""
    expected = mle.read_records(frame, loop[0])[0]
    frame = frame.copy()
    with sqlite3.connect(":memory:") as database:
        frame.to_sql("trend", database)
        frame.melt(ignore_index=False, var_name="tag").to_sql("archive", database)
        wide = pd.read_sql(
            "SELECT * FROM trend ORDER BY time DESC",
            database,
            index_col="time",
            parse_dates=["time"],
        )
        long = pd.read_sql("SELECT * FROM archive", database, parse_dates=["time"])
        nothing = pd.read_sql(
            "SELECT * FROM trend WHERE level > 1e9",
            database,
            index_col="time",
            parse_dates=["time"],
        )
    long = long.pivot(index="time", columns="tag", values="value")
    for other in (wide.sort_index(), long):
        record = mle.read_records(other, loop[0])[0]
        assert record.outputs.tobytes() == expected.outputs.tobytes()
        assert record.inputs.tobytes() == expected.inputs.tobytes()
    with refused("follows"):
        mle.read_records(wide, loop[0])
    with refused("data frame has 0 rows"):
        mle.correct(loop[0], nothing)


def test_nan_that_is_there(loop, frame):
    """Single bad samples are left out; too many are the record's end."""
    frame.iloc[40:43, frame.columns.get_loc("level")] = np.nan
    assert mle.correct(loop[0], frame, **FAST).decision == "corrected"
    record = mle.read_records(frame, loop[0])[0]
    assert np.flatnonzero(np.isnan(record.outputs[:, 0])).tolist() == [40, 41, 42]


def test_dates_of_every_package_are_texts():
    whole = np.datetime64("2024-03-04T10:00")
    dates = [whole, whole.astype("datetime64[ns]"), pd.Timestamp("2024-03-04 10:00")]
    assert text_of(dates) == ",".join(["2024-03-04T10:00:00"] * 3)
    assert text_of(np.array(dates[:2], dtype="datetime64[ms]")) == text_of(dates[:2])


def test_outputs_that_are_judged(loop, frame):
    model = mle.from_fopdt([[2.0], [1.0]], 10.0, 2.0, inputs=["valve"], outputs=["level", "flow"])
    with refused("no column 'flow'"):
        mle.correct(model, frame, **FAST)
    result = mle.correct(model, frame, outputs=["level"], **FAST)
    assert result.decision == "corrected"
    assert {output for output, _ in result.elements.index} == {"level"}
    with refused("no such output; it has level, flow"):
        mle.correct(model, frame, outputs="levle", **FAST)


def test_modes_in_a_data_frame(loop, frame, tmp_path):
    frame["LC.MODE"] = ["MAN" if 100 <= k < 150 else "cas" for k in range(len(frame))]
    modes = {"LC.MODE": "valve"}
    result = mle.correct(loop[0], frame, mode_tag=modes, **FAST)
    told = [note.text for note in result.notes if note.text.startswith("LC.MODE")]
    assert len(told) == 1 and "by hand for 17 %" in told[0]
    file = tmp_path / "record.csv"
    frame.rename_axis("time").to_csv(file)
    of_file = mle.correct(loop[0], str(file), mode_tag=modes, **FAST)
    assert told == [note.text for note in of_file.notes if note.text.startswith("LC.MODE")]
    with refused("'broken' is not a mode .mode_tag."):
        mle.correct(loop[0], frame.replace("MAN", "broken"), mode_tag=modes, **FAST)
    with refused("not for mle.Record"):
        mle.correct(loop[0], loop[2], mode_tag=modes)


def test_declared_sampling(loop, frame):
    output = '"name": "level", "unit": ""'
    text = loop[0].to_json()
    assert output in text
    late = mle.ProcessModel.from_json(
        text.replace(output, output + ', "sampling": {"late_by": 3}')
    )
    plain = mle.read_records(frame, loop[0])[0]
    shifted = mle.read_records(frame, late)[0]
    np.testing.assert_array_equal(shifted.outputs[:-3], plain.outputs[3:])
    np.testing.assert_array_equal(shifted.inputs, plain.inputs)
