"""What a result offers; threads, signals, memory."""

import os
import pickle
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import mle

FAST = {"estimator": "output_error", "threads": 1}


@pytest.fixture(scope="module")
def result(loop):
    model, plant, record = loop
    return mle.correct(model, record, truth=plant, **FAST)


def test_what_it_found(result, loop):
    model, plant, _ = loop
    assert result.decision == "corrected" and result.usable
    assert result.p_value < 1e-3
    assert result.initial == model
    row = result.elements.loc[("level", "valve")]
    assert row.gain_lower < 2.6 < row.gain_upper
    assert row.gain_initial == 2.0 and row.aged
    gain = result.corrected.static_gains[0, 0]
    assert gain == row.gain_corrected
    assert result.fopdt.static_gains[0, 0] == pytest.approx(gain)
    assert result.reasons and all(str(reason) == reason.text for reason in result.reasons)
    assert result.to_dict()["truth"]["E_corrected"] < result.to_dict()["truth"]["E_initial"]
    assert result.verdict and result.advice


def test_step_responses_and_their_band(result, loop):
    model, plant, _ = loop
    response = result.step_response
    samples = len(response.time)
    assert response.initial.shape == response.corrected.shape == (samples, 1, 1)
    np.testing.assert_array_equal(
        response.initial, model.step_response(response.time[1], samples)
    )
    np.testing.assert_allclose(
        response.corrected, result.corrected.step_response(response.time[1], samples), atol=1e-12
    )
    assert (response.lower <= response.corrected).all()
    assert (response.corrected <= response.upper).all()
    assert not response.corrected.flags.writeable


def test_state_space_is_as_near_as_it_says(result):
    system = result.state_space
    order = len(system.A)
    gain = system.C @ np.linalg.solve(np.eye(order) - system.A, system.B) + system.D
    allowed = result.to_dict()["state_space"]["largest_difference"]
    largest = abs(result.corrected.static_gains).max()  # it does not overshoot
    assert abs(gain - result.corrected.static_gains).max() <= 1.01 * allowed * largest
    assert 0.0 < allowed < 0.05
    assert system.outputs == ["level"]


def test_filters_of_disturbances(result, loop):
    model, _, record = loop
    row = result.filters.loc["level"]
    (written,) = result.to_dict()["filter"]
    assert row.bias_gain == written["bias"]["gain"] and row.gain_in_use == 1.0
    assert row.bias_better and row.bias_error < row.error_in_use and row.missing == ""
    form = result.state_space.disturbance_model
    np.testing.assert_array_equal(form.K[:, 0], written["kalman"]["gain"])
    assert form.R[0] == written["measurement_variance"]
    assert abs(np.linalg.eigvals(form.A - form.K @ form.C)).max() < 1.0
    again = pickle.loads(pickle.dumps(result))
    assert again.filters.equals(result.filters)
    np.testing.assert_array_equal(again.state_space.disturbance_model.Q, form.Q)
    without = mle.correct(model, record, filter=False, **FAST)
    assert without.filters.empty and "filter" not in without.to_dict()
    assert without.state_space.disturbance_model is None


def test_the_next_move(loop):
    model, _, record = loop
    kept = mle.correct(model, record, **FAST)
    assert kept.plan is None
    move = mle.correct(model, record, plan=True, plan_error=0.0005, **FAST).plan
    assert move.state in ("found", "out_of_reach") and move.cost > 0.0
    assert move.steps.index[0] == 0.0 and move.steps.index[-1] == move.duration
    assert (move.gains["after"] < move.gains["before"]).all()
    assert (move.channels["band_high"] <= move.channels["limits_high"] + 1e-9).all()
    assert "set point of level" in str(move) or "limit" in move.hindrance
    known = mle.correct(model, record, plan=True, plan_error=0.9, **FAST).plan
    assert known.state == "nothing_needed" and known.steps.empty and known.cost == 0.0
    with pytest.raises(mle.InvalidInputError, match="plan_longest"):
        mle.correct(model, record, plan=True, plan_longest=0, **FAST)


def test_page_and_files(result, tmp_path):
    result.report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "<svg" in page
    assert "mle.correct(model, records" in page
    assert "corrected" in result._repr_html_()
    result.write(tmp_path / "all")
    assert (tmp_path / "all" / "result.json").read_text() == result.to_json()
    assert mle.ProcessModel.read(tmp_path / "all" / "model.json") == result.corrected


def test_what_is_printed(result):
    first, second, *_ = str(result).split("\n")
    assert first == "Use the corrected model in the controller."
    assert second.startswith("Gain of level ← valve rose by ")
    assert "report.html" not in str(result)
    summary = result.summary()
    assert summary.startswith(str(result)) and "What to do" in summary and "--" not in summary
    shown = result._repr_html_()
    assert shown.count("data:image/svg+xml;base64,") == 2 and second.rstrip(".") in shown


def test_figure(result):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    (axis,) = result.plot().axes
    assert "changed" in axis.get_title() and len(axis.lines) == 2
    pyplot.close("all")


def test_pickled_results_are_the_same(result):
    again = pickle.loads(pickle.dumps(result))
    assert again.to_json() == result.to_json()
    assert again.report_html() == result.report_html()
    assert again.corrected == result.corrected
    assert again.reasons == result.reasons
    assert again.summary() == result.summary() and again._repr_html_() == result._repr_html_()
    np.testing.assert_array_equal(again.step_response.upper, result.step_response.upper)
    assert again.elements.equals(result.elements)


def test_pickled_records_are_the_same(loop):
    record = loop[2]
    again = pickle.loads(pickle.dumps(record))
    assert again.outputs.tobytes() == record.outputs.tobytes()
    assert again.set_points.tobytes() == record.set_points.tobytes()
    assert (again.sample_time, again.start_time) == (record.sample_time, record.start_time)


def test_progress_is_told_and_may_stop(loop):
    model, _, record = loop
    told = []
    mle.correct(model, record, progress=lambda *report: told.append(report), **FAST)
    assert told[0] == ("reading the records", 0.0)
    assert any("fitting" in stage for stage, _ in told)
    assert all(0.0 <= fraction <= 1.0 for _, fraction in told)
    with pytest.raises(mle.CancelledError):
        mle.correct(model, record, progress=lambda *report: False, **FAST)
    with pytest.raises(ZeroDivisionError):
        mle.correct(model, record, progress=lambda *report: 1 / 0, **FAST)


def test_two_threads_at_once(loop):
    model, _, record = loop
    expected = mle.correct(model, record, **FAST).to_json()
    found = [None] * 4

    def work(k):
        for _ in range(3):
            found[k] = mle.correct(model, record, **FAST).to_json()

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 4


def test_other_threads_run_meanwhile(loop):
    """The lock is free during a correction: another thread of Python goes on."""
    model, _, record = loop
    stop = threading.Event()
    counts = []

    def count():
        n = 0
        while not stop.wait(0.001):
            n += 1
        counts.append(n)

    thread = threading.Thread(target=count)
    thread.start()
    mle.correct(model, record, estimator="arx", conversion_samples=200_000)
    stop.set()
    thread.join()
    assert counts[0] > 0


INTERRUPTED = """
import os, signal, threading
import mle
model = mle.from_fopdt([[2.0]], 10.0, 2.0, inputs=["u"], outputs=["y"])
record = mle.simulate(model, setpoints=[("y", 400, 1.0)], duration=4000, sample_time=0.2,
                      control_period=2)
told = []
def progress(stage, fraction):
    if not told:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
    told.append(stage)
try:
    mle.correct(model, record, progress=progress, conversion_samples=3_000_000, estimator="arx")
    print("not interrupted")
except KeyboardInterrupt:
    print("interrupted")
"""


def test_keyboard_interrupt_stops_and_the_process_ends_in_order():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.returncode) == ("interrupted\n", 0), done.stderr


EXHAUSTED = """
import resource
import mle
model = mle.from_fopdt([[2.0]], 10.0, 2.0, inputs=["u"], outputs=["y"])
record = mle.simulate(model, setpoints=[("y", 100, 1.0)], duration=400, sample_time=1,
                      control_period=2)
# Before, the threads are made, and what they have of their own: the system ends a process
# that has no memory for it.
mle.correct(model, record, estimator="arx")
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 60_000_000, -1))
try:
    mle.correct(model, record, estimator="arx", conversion_samples=10_000_000)
except MemoryError:
    print("refused")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_exhausted_memory_is_an_exception():
    """The work runs on a thread of its own, where nobody else would catch it."""
    done = subprocess.run(
        [sys.executable, "-c", EXHAUSTED], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.returncode) == ("refused\n", 0), done.stderr


def resident_megabytes():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_corrections_leave_no_memory_behind(loop):
    """A result is 0.2 MB and more: 40 that were kept would be seen."""
    model, _, record = loop

    def correct_often(times):
        for _ in range(times):
            mle.correct(model, record, **FAST)
            with pytest.raises(mle.InvalidInputError):
                mle.correct(model, record, confidence=2)

    correct_often(10)
    before = resident_megabytes()
    correct_often(40)
    assert resident_megabytes() - before < 6.0


def test_signals_are_python_s_own_afterwards(result):
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
