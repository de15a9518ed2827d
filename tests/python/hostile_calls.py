#!/usr/bin/env python3
"""Calls of the package with arguments that nobody should pass.

    hostile_calls.py [--seconds=N] [--first=CASE] [--count=N]

A case is a usual call in which one to three arguments, or parts of them, are something
else: other types and shapes, no numbers, numbers at the ends of their range, texts that
are none. It must return, or raise what docs/python.md promises: mle.Error, TypeError,
ValueError, OverflowError, LookupError or MemoryError. Anything else is a finding, and so
is a call that does not return; what returns is used. The number of a case makes it again:
`--first=CASE --count=1`.

Memory is limited, so that what is asked for without bounds is refused.
"""

import argparse
import contextlib
import datetime
import decimal
import faulthandler
import fractions
import json
import math
import os
import pathlib
import random
import resource
import sys
import tempfile
import time
import traceback
import types
import warnings

import numpy as np
import pandas as pd

import mle

ALLOWED = (mle.Error, TypeError, ValueError, OverflowError, LookupError, MemoryError)
MEMORY = 6 << 30  # bytes of addresses
CASE_SECONDS = 60  # after which a call does not return
PATIENCE = 3.0  # s, until progress asks to stop


class Own(Exception):
    """Raised by what is called back: it must come out as it is."""


class Odd:
    """Neither number, sequence, nor array, though it says so."""

    def __init__(self, answer):
        self.answer = answer

    def _say(self, *_):
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer

    __float__ = __index__ = __len__ = __getitem__ = __iter__ = __array__ = __fspath__ = _say


def hostile_value(draw):
    """One of the things that stand where another thing should."""
    kinds = [
        lambda: draw.choice([None, True, False, NotImplemented, ...]),
        lambda: draw.choice([0, 1, -1, 2, 7, 255, 2**31 - 1, 2**31, -(2**31) - 1, 2**63, -(2**63), 2**64, 10**400]),
        lambda: draw.choice([0.0, -0.0, 0.5, 1e-3, 1e3, 1e12, -1e12, 1e154, 1e155, -1e300, 1.7e308, 5e-324, 1e-300]),
        lambda: draw.choice([math.nan, math.inf, -math.inf]),
        lambda: draw.choice(["", " ", "\0", "level", "valve", "a=b", ",", ":", "1:2:3", "nan", "1e999", "é", "\ud800",
                             "none", "auto", "x" * 100_000, "--", "{}", "[", "../..", "%s%n", "\n", "µ\u202e"]),
        lambda: draw.choice([b"", b"bytes\xff", bytearray(b"x"), memoryview(b"abcdefgh")]),
        lambda: draw.choice([[], (), {}, set(), [[]], [[[]]], [None], [math.nan], ["a", 1], {"level": 1}, {1: 2}]),
        lambda: draw.choice([range(3), iter([1, 2]), (x for x in "ab"), object(), object, len, lambda *_: None]),
        lambda: draw.choice([1j, decimal.Decimal("1e400"), decimal.Decimal("NaN"), fractions.Fraction(1, 3)]),
        lambda: draw.choice([datetime.datetime(1, 1, 1), datetime.date(9999, 12, 31), datetime.timedelta(1), pd.NaT,
                             pd.NA, pd.Timestamp.max, np.datetime64("NaT"), np.timedelta64(1, "s")]),
        lambda: draw.choice([pathlib.Path("nowhere"), pathlib.Path("."), pathlib.Path("\0")]),
        lambda: Odd(draw.choice([0, -1, 2**70, "text", None, Own("odd"), math.nan, [1, 2], np.zeros(2)])),
        lambda: hostile_array(draw),
        lambda: draw.choice([pd.Series([1.0, math.nan]), pd.DataFrame(), pd.DataFrame({"level": ["a"]}), pd.Index([])]),
    ]
    return draw.choice(kinds)()


def hostile_array(draw):
    shape = draw.choice([(), (0,), (1,), (3,), (0, 0), (0, 3), (3, 0), (1, 1), (2, 2), (7, 1), (1, 7), (2, 1, 2),
                         (1,) * 30, (4, 4)])
    kind = draw.choice(["f8", "f4", "f2", "i1", "u8", "?", "c16", "O", "U3", "M8[s]", "m8[s]", ">f8", "S2",
                        [("a", "f8")]])
    array = np.zeros(shape, dtype=kind)
    if np.dtype(kind).kind == "f" and array.size:
        array[...] = draw.choice([1.0, math.nan, math.inf, 1e4, -1.0])
    if draw.random() < 0.2:
        array = np.broadcast_to(array, draw.choice([(10**6,), (10**10,), (3, 1), (10**9, 1)]) if array.ndim < 1
                                else array.shape)
    if draw.random() < 0.2:
        array = array[..., ::-1] if array.ndim else array
    return array


def damaged(value, draw):
    """`value` with something hostile in its place or in it."""
    if draw.random() < 0.2:
        return hostile_value(draw)
    if isinstance(value, dict) and value:
        value = dict(value)
        key = draw.choice(list(value))
        how = draw.randrange(4)
        if how == 0:
            del value[key]
        elif how == 1:
            value[draw.choice(["", "other", 3, None])] = value.pop(key)
        else:
            value[key] = damaged(value[key], draw)
        return value
    if isinstance(value, (list, tuple)) and len(value):
        parts = list(value)
        at = draw.randrange(len(parts))
        how = draw.randrange(5)
        if how == 0:
            del parts[at]
        elif how == 1:
            parts.insert(at, parts[at])
        else:
            parts[at] = damaged(parts[at], draw)
        return type(value)(parts)
    if isinstance(value, np.ndarray) and value.size:
        return damaged_array(value, draw)
    if isinstance(value, pd.DataFrame) and value.size:
        return damaged_frame(value, draw)
    if isinstance(value, str) and value:
        at = draw.randrange(len(value))
        return value[:at] + draw.choice(["", "\0", "é", "9", "-", "e", '"', ",", ":", " "]) + value[at + 1:]
    if isinstance(value, (int, float)) and abs(value) < 1e300:
        return draw.choice([value * factor for factor in (-1, 0, 2, 10, 0.1, 1e6, 1e-6, 1e300)]
                           + [math.nan, math.inf, 2**31, 2**31 - 1, 2**63, 5e-324, "1", None])
    return hostile_value(draw)


def damaged_array(array, draw):
    how = draw.randrange(9)
    if array.dtype.kind not in "fiu" or array.ndim == 0 or array.size > 10**6:
        return array[..., None]
    array = array.astype(float)
    if how == 0:
        return array.T
    if how == 1:
        return array[..., : draw.randrange(array.shape[-1] + 1)]
    if how == 2:
        return array[: draw.randrange(len(array) + 1)]
    if how == 3:
        return array[::-1]
    if how == 4:
        return array.astype(draw.choice(["f4", "i8", "c16", "O", "U8", "?"]))
    if how == 5:
        return array * draw.choice([1e300, 1e-300, -1.0, 0.0, 1e154])
    if how == 6:
        return np.repeat(array, 2, axis=draw.randrange(array.ndim))
    if how == 7:
        return array[None]
    flat = array.reshape(-1)
    begin = draw.randrange(flat.size)
    flat[begin : begin + draw.choice([1, 1, 5, 10**6])] = draw.choice(
        [math.nan, math.inf, -math.inf, 1.7e308, -1e155, 5e-324, 0.0, 1.0])
    return array


def damaged_frame(frame, draw):
    frame = frame.copy()
    column = draw.randrange(frame.shape[1])
    how = draw.randrange(11)
    if how == 0:
        return frame.drop(columns=frame.columns[column])
    if how == 1:
        return frame.rename(columns={frame.columns[column]: draw.choice(["", 3, None, "time", frame.columns[0]])})
    if how == 2:
        return frame.iloc[: draw.randrange(len(frame) + 1)]
    if how == 3:
        return frame.sample(frac=1.0, random_state=draw.randrange(1000))
    if how == 4:
        return frame.iloc[:: draw.randrange(1, 50)]
    if how == 5:
        frame.index = draw.choice([
            pd.date_range("1677-09-22", periods=len(frame), freq="s"), pd.RangeIndex(len(frame)),
            pd.Index(np.full(len(frame), np.nan)), pd.MultiIndex.from_product([[1], range(len(frame))]),
            pd.Index(np.logspace(-300, 300, len(frame)), name="time"), pd.timedelta_range(0, periods=len(frame)),
            pd.date_range("2024-10-27", periods=len(frame), freq="min", tz="Europe/Berlin"),
            pd.Index(np.arange(len(frame)) * 1e17, name="time"), pd.period_range("2024", periods=len(frame), freq="D")])
        return frame
    if how == 6:
        frame.iloc[:, column] = draw.choice([math.nan, math.inf, 0.0, 1e300])
        return frame
    if how == 7:
        return frame.astype({frame.columns[column]: draw.choice(["object", "str", "category", "float32", "Int64"])},
                            errors="ignore")
    if how == 8:
        return pd.concat([frame, frame.iloc[:, [column]]], axis=1)
    if how == 9:
        return pd.concat([frame, frame])
    rows = slice(draw.randrange(len(frame)), None, draw.randrange(1, 9))
    frame.iloc[rows, column] = draw.choice([math.nan, math.inf, 1e155, -1e300, 0.0])
    return frame


def stop_soon():
    begin = time.monotonic()
    return lambda stage, fraction: time.monotonic() - begin < PATIENCE


def affordable(options):
    """Without steps so fine that the call does what it should, for hours."""
    step = options.get("sample_time")
    if isinstance(step, float) and 0.0 < step < 1e-3:
        options["sample_time"] = 0.0
    return options


class World:
    """Usual calls, and what they need."""

    NAMES = {"inputs": ["valve"], "outputs": ["level"]}
    LOOP = {"setpoints": [("level", 30, 1.0), ("level", 90, -0.5)], "duration": 150, "sample_time": 1.0,
            "control_period": 2, "noise_variance": 1e-4, "seed": 3}

    def __init__(self):
        self.model = mle.from_fopdt([[2.0]], 10.0, 2.0, **self.NAMES)
        self.plant = mle.from_fopdt([[2.6]], 13.0, 2.0, **self.NAMES)
        self.record = mle.simulate(self.model, self.plant, **self.LOOP)
        self.frame = mle.to_dataframe(self.record, self.model, start="2024-03-04 06:00")
        self.two = mle.from_fopdt([[1.0, 0.5], [0.2, 2.0]], [[5.0, 4.0], [3.0, 8.0]], 1.0)
        time_ = np.arange(1, 31)
        self.steps = np.stack([np.stack([1 - np.exp(-time_ / 5.0), 0 * time_], 1),
                               np.stack([0.5 - 0.5 * np.exp(-time_ / 3.0), 2 - 2 * np.exp(-time_ / 4.0)], 1)], 1)
        self.ageing = {"time_factor": 525960,
                       "elements": [{"output": "level", "input": "valve", "gain": [[0, 1.0], [1, 0.6]]}]}
        self.life = {"years": 0.5, "change_every": "30d", "sample_time": 1, "control_period": 2,
                     "policies": "never,output_error:3,perfect", "seeds": 1, "figures": False}
        self.campaign = {
            "version": 1, "name": "small", "seeds": {"first": 1, "count": 1},
            "models": [{"name": "tank", "model": json.loads(self.model.to_json())}],
            "mismatches": [{"name": "aged", "plant": json.loads(self.plant.to_json())}],
            "noise_variances": [1e-4], "sample_time": 1, "response_horizon": 60, "order": 20,
            "windows": [{"name": "w", "setpoint_step": 1, "window": 150, "duration": 400, "step_time": 200}],
            "estimators": ["none", "output_error:none"],
        }
        self.options = {
            "correct": self.defaults(mle._mle._correct_options()),
            "simulate": self.defaults(mle._mle._simulate_options()),
            "mpc": self.defaults(mle._mle._mpc_options()),
            "lifecycle": self.defaults(mle._mle._lifecycle_options()),
        }

    @staticmethod
    def defaults(table):
        return {option[1]: option[2] for option in table}

    def some_options(self, kind, draw):
        """A few at their defaults; each may be damaged."""
        table = self.options[kind]
        return {name: table[name] for name in draw.sample(sorted(table), draw.choice([0, 1, 1, 2]))}

    def calls(self):
        return [name for name in dir(self) if name.startswith("call_")]

    # Each returns (function of the keywords, usual keywords).

    def call_from_fopdt(self, draw):
        return mle.from_fopdt, dict(gain=[[1.0, 0.5], [0.0, 2.0]], time_constant=[[5.0, 4.0], [3.0, 8.0]],
                                    delay=[[0.0, 1.0], [2.0, 0.5]], inputs=["a", "b"], outputs=["c", "d"],
                                    time_unit="s", name="m", input_units=["%", "t/h"], output_units=["K", "bar"],
                                    disturbances=["b"], integrating=draw.choice([False, [[True, False], [0, 1]]]))

    def call_from_transfer_functions(self, draw):
        return mle.from_transfer_functions, dict(numerators=[[[1.0], [0.5, 1.0]]], delays=[[0.0, 1.0]],
                                                 denominators=[[[5.0, 1.0], [8.0, 6.0, 1.0]]], time_unit="h")

    def call_from_step_responses(self, draw):
        return mle.from_step_responses, dict(coefficients=self.steps, dt=1.0, name="steps")

    def call_from_state_space(self, draw):
        return mle.from_state_space, dict(A=[[-0.2, 0.0], [0.1, -0.5]], B=[[1.0], [0.0]], C=np.eye(2),
                                          D=[[0.0], [0.0]], delays=[[1.0], [0.0]])

    def call_state_space(self, draw):
        return mle.StateSpaceModel, dict(A=np.diag([0.8, 0.5]), B=np.ones((2, 1)), C=np.eye(2), D=np.zeros((2, 1)),
                                         dt=1.0, inputs=["u"], outputs=["y", "z"], input_delays=[2],
                                         output_delays=[0, 1], time_unit="min", name="m")

    def call_from_systems(self, draw):
        system = types.SimpleNamespace(num=np.ones(1), den=np.array([5.0, 1.0]))
        return mle.from_systems, dict(systems=[[system]], delays=[[1.0]])

    def call_from_json(self, draw):
        kind = draw.choice([mle.ProcessModel, mle.StepResponseModel, mle.StateSpaceModel])
        return kind.from_json, dict(json=self.two.to_json())

    def call_damaged_document(self, draw):
        document = json.loads(self.two.to_json())
        return lambda document: mle.ProcessModel.from_json(json.dumps(document)), dict(document=document)

    def call_element(self, draw):
        return self.two.element, dict(output=1, input=0)

    def call_step_response(self, draw):
        return self.two.step_response, dict(sample_time=1.0, samples=20)

    def call_record(self, draw):
        return mle.Record, dict(outputs=self.record.outputs, inputs=self.record.inputs,
                                set_points=self.record.set_points, sample_time=1.0, start_time=0.0)

    def call_to_dataframe(self, draw):
        return mle.to_dataframe, dict(record=self.record, model=self.model, start="2024-03-04 06:00")

    def call_read_records(self, draw):
        return (lambda records, model, options: mle.read_records(records, model, **options),
                dict(records=draw.choice([self.frame, [self.frame.iloc[:70], self.frame.iloc[70:]]]),
                     model=self.model, options=draw.choice([{}, {"time_column": "time"}, {"max_gap": 3}])))

    def call_compare(self, draw):
        return (lambda records, model, horizon, options: mle.compare(records, model, horizon=horizon, **options).fits,
                dict(records=draw.choice([self.frame, self.record]), model=draw.choice([self.model, self.plant]),
                     horizon=draw.choice([None, 1, 20]), options=draw.choice([{}, {}, {"max_gap": 3}])))

    def call_resid(self, draw):
        return mle.resid, dict(records=self.record, model=self.model, max_lag=draw.choice([None, 7]))

    def call_lsim(self, draw):
        return mle.lsim, draw.choice([dict(model=self.model, U=self.frame[["valve"]]),
                                      dict(model=self.two, U=np.ones((20, 2)), T=1.0)])

    def call_advice(self, draw):
        def run(records, model, options):
            return str(mle.advice(records, model, **affordable({**options})))

        return run, dict(records=self.record, model=self.model, options=self.some_options("correct", draw))

    def call_plant(self, draw):
        def run(model, sample_time, inputs):
            plant = mle.Plant(model, sample_time=sample_time)
            plant.advance(inputs)
            return plant.advance(inputs)

        return run, dict(model=self.two, sample_time=1.0, inputs=[1.0, 0.0])

    def call_mpc(self, draw):
        def run(model, options, measured, set_points, preview, resting, exchanged):
            controller = mle.Mpc(model, **options)
            controller.step(measured, set_points)
            controller.step_with_preview(measured, preview)
            controller.restart(*resting)
            with contextlib.suppress(mle.InvalidInputError):
                controller.exchange_model(exchanged)
            controller.step(measured, set_points)
            return controller.gain, controller.predicted_outputs

        return run, dict(model=self.two, options=self.some_options("mpc", draw), measured=[0.0, 0.1],
                         set_points=np.ones(2), preview=np.ones((30, 2)), resting=[[0.0, 0.0], [0.0, 0.0]],
                         exchanged=self.two)

    def call_disturbances(self, draw):
        def run(model, disturbances):
            controller = mle.Mpc(model)
            controller.measure_disturbances(disturbances)
            return controller.step([0.0], [1.0])

        return run, dict(model=mle.from_fopdt([[1.0, 0.5]], 5.0, disturbances=["u2"]), disturbances=[0.3])

    def call_simulate(self, draw):
        def run(model, plant, options, more):
            return mle.simulate(model, plant, **affordable({**options, **more}))

        return run, dict(model=self.model, plant=self.plant, options=self.LOOP,
                         more=self.some_options("simulate", draw))

    def call_simulate_with(self, draw):
        def run(answer, options):
            def controller(measured, set_points, last):
                if isinstance(answer, Own):
                    raise answer
                return answer

            return mle.simulate(self.model, self.plant, controller=controller, **options)

        return run, dict(answer=draw.choice([np.zeros(1), Own("controller")]), options=self.LOOP)

    def call_correct(self, draw):
        def run(model, records, options, more):
            result = mle.correct(model, records, progress=stop_soon(), **affordable({**options, **more}))
            use(result)
            return result

        return run, dict(model=draw.choice([self.model, self.model, self.two]),
                         records=draw.choice([self.frame, self.record, [self.record, self.record]]),
                         options={"estimator": draw.choice(["output_error", "arx"]), "figures": False}
                         if "figures" in self.options["correct"] else {"estimator": "output_error"},
                         more=self.some_options("correct", draw))

    def call_progress(self, draw):
        return mle.correct, dict(model=self.model, records=self.record, estimator="output_error",
                                 progress=draw.choice([lambda *_: hostile_value(draw), lambda *_: False, None]))

    def call_study(self, draw):
        return mle.study, dict(campaign=self.campaign, figures=False, threads=draw.choice([0, 1, 2]),
                               progress=stop_soon())

    def call_lifecycle(self, draw):
        def run(model, ageing, options, more):
            return mle.lifecycle(model, ageing, progress=stop_soon(), **affordable({**options, **more}))

        return run, dict(model=self.model, ageing=self.ageing, options=self.life,
                         more=self.some_options("lifecycle", draw))


def use(result):
    """What a result has: finite where it says so, and readable again."""
    result.to_dict()
    repr(result)
    if result.usable:
        mle.ProcessModel.from_json(result.process.to_json())
        if not np.isfinite(result.process.static_gains).all():
            raise AssertionError("gains that are not finite")


def run_case(world, number):
    """What the case raised, or None. Raises what is a finding."""
    draw = random.Random(number)
    name = draw.choice(world.calls())
    call, keywords = getattr(world, name)(draw)
    keywords = dict(keywords)
    for _ in range(draw.choice([1, 1, 1, 2, 3])):
        at = draw.choice(sorted(keywords))
        if at != "progress":
            keywords[at] = damaged(keywords[at], draw)
    try:
        result = call(**keywords)
    except ALLOWED as error:
        if not isinstance(error, MemoryError) and not str(error).strip():
            raise AssertionError(f"{type(error).__name__} without a text") from error
        return error
    except Own as error:
        return error
    repr(result)
    return None


def limit_memory():
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))


def run(first, count, seconds, tell):
    """Runs cases; returns (cases, those that raised, findings)."""
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    world = World()
    begin = time.monotonic()
    raised = 0
    findings = []
    number = first
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        while (number < first + count) if count else time.monotonic() - begin < seconds:
            tell(number)
            faulthandler.dump_traceback_later(CASE_SECONDS, exit=True, file=sys.__stderr__)
            try:
                raised += run_case(world, number) is not None
            except Exception as error:  # everything that is not allowed is to be seen
                findings.append((number, error))
            number += 1
    faulthandler.cancel_dump_traceback_later()
    return number - first, raised, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--first", type=int, default=None, metavar="CASE", help="default: of the time")
    parser.add_argument("--count", type=int, default=0)
    flags = parser.parse_args()
    first = flags.first if flags.first is not None else time.time_ns() // 1_000_000 * 1000
    limit_memory()
    faulthandler.enable()

    def tell(number):  # The last one is that which ended the process.
        os.write(2, f"case {number}\n".encode())

    cases, raised, findings = run(first, flags.count, flags.seconds, tell)
    for number, error in findings:
        print(f"case {number}: {type(error).__name__}: {error}")
        traceback.print_exception(type(error), error, error.__traceback__, file=sys.stdout)
    print(f"{cases} calls, {raised} of them refused, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
