"""Records from data frames, arrays and files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, List, Mapping, Sequence, Tuple

from . import _mle
from ._mle import Record
from .model import KINDS, ModelLike, given_model, read_model
from .options import names_of, option_texts, takes_keywords, text_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .keywords import ReadOptions

# Options that say how a text is read, and mean nothing for a table.
_OF_TEXT = (
    "time_format number_unit separate_files separator decimal lines_above_header "
    "rows_below_header header spread_repeated_times tag_column value_column quality_column "
    "empty_fields quality_suffixes good_qualities any_word_is_bad begin end query table columns"
).split()


def _is_frame(value: Any) -> bool:
    return hasattr(value, "columns") and hasattr(value, "index") and hasattr(value, "iloc")


def _localized(index: Any, name: str, zone: str) -> Any:
    try:
        return index.tz_localize(zone, ambiguous="infer")
    except LookupError:
        raise _mle_error(
            f"there is no time zone '{zone}' on this machine; zones have names such as "
            "Europe/Berlin or UTC",
            "time_zone",
        ) from None
    except Exception as error:  # pytz's or pandas' own, by the version of pandas
        raise _mle_error(
            f"{name}: not all of its times can be times in {zone}: {error} (where clocks are set "
            "back, an hour is there twice or not told apart; where they are set forward, an hour "
            "is not there); use an index with a time zone (tz_localize)",
            "time_zone",
        ) from error


def _dates(index: Any, name: str, zone: str) -> Tuple[Any, str]:
    """Seconds since 1970 (UTC), NaN for NaT, and the zone of dates."""
    import numpy as np

    if index.tz is None and zone:
        index = _localized(index, name, zone)
    if index.tz is not None:
        zone = str(index.tz)
        index = index.tz_convert("UTC").tz_localize(None)
    nanoseconds = index.values.astype("datetime64[ns]").view("int64")
    seconds = nanoseconds / 1e9
    if index.hasnans:
        seconds[np.asarray(index.isna())] = np.nan
    return np.ascontiguousarray(seconds), zone


def _times(frame: Any, name: str, time_column: str, zone: str):
    """(times, whether they are dates, zone, names of columns that are samples)."""
    import numpy as np
    import pandas as pd

    index = frame.index
    columns = list(range(len(frame.columns)))
    at = [k for k in columns if frame.columns[k] == time_column]
    if not at and getattr(index.dtype, "kind", "O") in "iu" and index.name != time_column:
        # Whatever their column is called, there may be dates.
        at = [k for k in columns if getattr(frame.dtypes.iloc[k], "kind", "O") == "M"]
    if not isinstance(index, pd.DatetimeIndex) and len(at) == 1:
        columns.remove(at[0])
        index = pd.Index(frame.iloc[:, at[0]])
    elif getattr(index.dtype, "kind", "O") in "iu" and index.name != time_column:
        raise _mle_error(
            f"{name} has no times: its index counts rows, and it has no column '{time_column}' and "
            "not one column of dates; its index must be a DatetimeIndex "
            "(frame.set_index(pandas.to_datetime(frame['Timestamp']))), or times in the model's "
            f"unit with the name '{time_column}'"
        )
    if isinstance(index, pd.DatetimeIndex):
        seconds, zone = _dates(index, name, zone)
        return seconds, True, zone, columns
    if getattr(index.dtype, "kind", "O") not in "fiu":
        raise _mle_error(
            f"{name}: its times are of the type {index.dtype}; they must be dates "
            "(pandas.to_datetime) or numbers in the model's time unit"
        )
    return np.ascontiguousarray(index.to_numpy(dtype=float)), False, zone, columns


def _mle_error(text: str, options: str = "") -> Exception:
    from .errors import _error

    return _error("INVALID_ARGUMENT", text, options)


def _samples(column: Any) -> Any:
    """float64, without a copy where the column is that; its dtype where it has
    no numbers."""
    import numpy as np

    kind = getattr(column.dtype, "kind", "O")
    if str(column.dtype) == "float64":
        samples = column.to_numpy()
        # Fields of packed rows lie between whole numbers.
        whole = samples.flags.aligned and samples.strides[0] % samples.itemsize == 0
        return samples if whole else samples.copy()
    if kind in "fiub":
        return np.asarray(column.to_numpy(dtype=float, na_value=np.nan))
    return str(column.dtype)


def _modes(column: Any) -> Any:
    """Words of modes as the numbers that stand for them; NaN where there is none."""
    import numpy as np
    import pandas as pd

    if getattr(column.dtype, "kind", "O") in "fiub":
        return _samples(column)
    words = {word: _mle._mode_code(str(word)) for word in pd.unique(column.dropna())}
    return np.asarray(column.map(words).to_numpy(dtype=float, na_value=np.nan))


def _mode_tags(options: Mapping[str, Any]) -> Sequence[str]:
    """The columns that mode_tag names, given as the command's text or a mapping."""
    tags = text_of(options.get("mode_tag", "")).split(",")
    return [tag.rpartition("=")[0] or tag for tag in tags if tag]


def _table(
    frame: Any, name: str, time_column: str, zone: str, modes: Sequence[str]
) -> tuple:
    times, dates, zone, columns = _times(frame, name, time_column, zone)
    samples = []
    for k in columns:
        column = str(frame.columns[k])
        read = _modes if column in modes else _samples
        samples.append((column, read(frame.iloc[:, k])))
    return (name, times, dates, zone, samples)


def _tables(frames: Sequence[Any], options: Mapping[str, Any]) -> tuple:
    for option in _OF_TEXT:
        if option in options:
            raise _mle_error(f"{option}: this option is for files, not for data frames", option)
    zoned = [getattr(frame.index, "tz", None) is not None for frame in frames]
    if len(set(zoned)) > 1:
        raise _mle_error(
            "some of the data frames have a time zone and others have none; localize all "
            "(tz_localize) or none"
        )
    names = ["data frame"]
    if len(frames) > 1:
        names = [f"data frame {k + 1}" for k in range(len(frames))]
    time_column = str(options.get("time_column", "time"))
    zone = str(options.get("time_zone", ""))
    return (
        "tables",
        [
            _table(frame, name, time_column, zone, _mode_tags(options))
            for frame, name in zip(frames, names)
        ],
    )


def source_of(records: Any, options: Mapping[str, Any]) -> tuple:
    """What the compiled module takes: ("files", paths), ("tables", tables) or
    ("records", records)."""
    if isinstance(records, (str, os.PathLike, Record)) or _is_frame(records):
        records = [records]
    if hasattr(records, "output_labels"):
        records = [_of_responses(records)]
    if hasattr(records, "to_frame"):
        raise TypeError(
            "a Series is one channel; a data frame has a column for each input and output: "
            "pandas.concat([series, ...], axis=1)"
        )
    records = list(records)
    if not records:
        raise _mle_error("there are no records")
    if all(isinstance(one, (str, os.PathLike)) for one in records):
        return ("files", [os.fspath(one) for one in records])
    if all(isinstance(one, Record) for one in records):
        for option in options:
            if option in (*names_of(_mle._read_options()), "mode_tag"):
                raise _mle_error(f"{option}: this option is not for mle.Record", option)
        return ("records", records)
    if all(_is_frame(one) for one in records):
        return _tables(records, options)
    kinds = sorted({type(one).__name__ for one in records})
    raise TypeError(
        "records must be paths, pandas data frames or mle.Record, one or several of a kind; "
        f"these are {', '.join(kinds)}"
    )


def _of_responses(response: Any) -> Any:
    """A data frame of python-control's TimeResponseData."""
    import numpy as np
    import pandas as pd

    count = len(response.time)
    samples = [np.reshape(part, (-1, count)).T for part in (response.outputs, response.inputs)]
    labels = [*response.output_labels, *response.input_labels]
    index = pd.Index(response.time, dtype=float, name="time")
    return pd.DataFrame(np.hstack(samples), index, labels)


def imported(records: Any, model: ModelLike, options: Mapping[str, Any], function: str) -> tuple:
    """Records, and the date of their time 0 (None: they have no dates)."""
    import pandas as pd

    if isinstance(records, KINDS):
        raise TypeError(f"{function}(): the records come first, then the model")
    texts = option_texts(function, _mle._read_options(), options)
    model = given_model(model)
    read, origin, zone = _mle._read_records(source_of(records, options), model, texts)
    if origin is None:
        return read, None
    start = pd.Timestamp(origin, unit="s", tz="UTC")
    return read, start.tz_convert(zone) if zone else start.tz_localize(None)


@takes_keywords(_mle._read_options())
def read_records(
    records: Any, model: ModelLike, **options: Unpack[ReadOptions]
) -> List[Record]:
    """The records of files, databases or data frames, as :func:`correct` uses them: columns
    matched with the channels of ``model``, resampled to one sample time, short
    gaps of inputs bridged. ``options`` are those of the command under "Reading
    the records" (docs/commands.md), as ``sample_time``, ``tags`` or
    ``max_gap``."""
    return imported(records, model, options, "read_records")[0]


def to_dataframe(
    record: Record,
    model: ModelLike,
    start: Any = None,
) -> Any:
    """A data frame of a record with the columns that the command reads: outputs,
    ``<output>_setpoint``, inputs. Its index is the time in the model's unit, or,
    with ``start`` (a date), a DatetimeIndex from there."""
    import pandas as pd

    model = read_model(model)
    if not isinstance(record, Record):
        raise TypeError(f"record must be mle.Record; this is {type(record).__name__}")
    for what, names, samples in (
        ("outputs", model.outputs, record.outputs),
        ("inputs", model.inputs, record.inputs),
    ):
        if samples.shape[1] != len(names):
            raise ValueError(
                f"the record has {samples.shape[1]} {what}; the model has {len(names)}"
            )
    columns = {}
    for i, name in enumerate(model.outputs):
        columns[name] = record.outputs[:, i]
        if record.set_points is not None:
            columns[name + "_setpoint"] = record.set_points[:, i]
    for j, name in enumerate(model.inputs):
        columns[name] = record.inputs[:, j]
    return pd.DataFrame(columns, index=times_of(record, model, start))


def pandas_unit(model: Any) -> str:
    return {"min": "m", "d": "D"}.get(model.time_unit, model.time_unit)


def times_of(record: Record, model: Any, start: Any = None) -> Any:
    """The index of a record: times in the model's unit, or dates from ``start`` on."""
    import numpy as np
    import pandas as pd

    times = record.start_time + record.sample_time * np.arange(len(record))
    if start is None:
        return pd.Index(times, name="time")
    spans = pd.to_timedelta(times, unit=pandas_unit(model))
    return pd.DatetimeIndex(pd.Timestamp(start) + spans, name="time")
