"""Records in a database, by the names and options of the command."""

import sqlite3

import pytest

import mle

FAST = {"estimator": "output_error"}
OF_THE_CALL = {"command", "flags", "inputs"}


@pytest.fixture
def database(frame, tmp_path):
    path = tmp_path / "plant.db"
    with sqlite3.connect(path) as connection:
        frame.to_sql("trend", connection)
        long = frame.melt(ignore_index=False, var_name="tag", value_name="value")
        long.to_sql("archive", connection)
    return f"sqlite:{path}"


def numbers(result):
    return {key: value for key, value in result.to_dict().items() if key not in OF_THE_CALL}


def test_table_and_query_give_the_numbers_of_the_file(loop, frame, database, tmp_path):
    path = tmp_path / "run.csv"
    frame.to_csv(path)
    of_file = numbers(mle.correct(loop[0], path, **FAST))
    of_table = mle.correct(loop[0], database, table="trend", **FAST)
    assert numbers(of_table) == of_file
    data = of_table.to_dict()["inputs"]["data"]
    assert [file["path"] for file in data] == [f"{database}, table trend"]
    assert len(data[0]["sha256"]) == 64
    query = "SELECT tag, time, value FROM archive ORDER BY time"
    of_query = numbers(mle.correct(loop[0], database, query=query, **FAST))
    assert "a long table" in of_query.pop("notes")[0]["text"]
    assert of_query == {key: value for key, value in of_file.items() if key != "notes"}


def test_time_range_and_records(loop, frame, database):
    options = {"table": "trend", "columns": ["level", "valve", "level_setpoint"]}
    whole = mle.read_records(database, loop[0], **options)
    part = mle.read_records(
        database, loop[0], begin=frame.index[20], end=str(frame.index[80]), **options
    )
    assert len(whole[0]) == len(frame)
    assert (part[0].outputs == whole[0].outputs[20:81]).all()


def test_mistakes_are_exceptions_without_a_password(loop, frame, database):
    with pytest.raises(mle.InvalidInputError, match="either table or query") as caught:
        mle.correct(loop[0], database)
    assert set(caught.value.options) == {"query", "table"}
    with pytest.raises(mle.InvalidInputError, match="table=trends|table = trends"):
        mle.correct(loop[0], database, table="trends")
    with pytest.raises(mle.InvalidInputError, match="no rows"):
        mle.correct(loop[0], database, query="SELECT * FROM trend WHERE 0")
    with pytest.raises(mle.InvalidInputError, match="has a password in it") as caught:
        mle.correct(loop[0], "postgresql://reader:geheim@host/plant", table="trend")
    assert "geheim" not in str(caught.value)
    for option in ({"table": "trend"}, {"query": "SELECT 1"}, {"begin": "2024-03-04"}):
        with pytest.raises(mle.InvalidInputError, match="for files, not for data frames"):
            mle.correct(loop[0], frame, **option)
