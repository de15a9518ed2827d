"""Campaigns and life cycles: the commands' numbers, in folders or in memory."""

import json
import os
import pickle
import subprocess
import sys

import pandas as pd
import pytest
from conftest import COMMANDS

import mle


def campaign_of(loop, **more):
    model, plant, _ = loop
    return {
        "version": 1,
        "name": "small",
        "seeds": {"first": 1, "count": 2},
        "models": [{"name": "loop", "model": model}],
        "mismatches": [{"name": "aged", "plant": plant}],
        "noise_variances": [1e-4],
        "sample_time": 1,
        "response_horizon": 60,
        "order": 20,
        "windows": [
            {"name": "w", "setpoint_step": 1, "window": 150, "duration": 400, "step_time": 200}
        ],
        "estimators": ["none", "output_error:none"],
        **more,
    }


def test_study_is_the_command(loop, tmp_path):
    told = []
    result = mle.study(
        campaign_of(loop),
        out=tmp_path / "study",
        figures=False,
        progress=lambda *report: told.append(report),
    )
    (tmp_path / "campaign.json").write_text(json.dumps(result.campaign))
    subprocess.run(
        [COMMANDS / "mle_study", f"--campaign={tmp_path}/campaign.json"]
        + [f"--out={tmp_path}/command", "--figures=false"],
        check=True,
        capture_output=True,
    )
    for name in ("runs.csv", "summary.csv", "summary.json"):
        ours = (tmp_path / "study" / name).read_text()
        assert ours == (tmp_path / "command" / name).read_text(), name
    assert result.to_json() == (tmp_path / "study" / "summary.json").read_text()
    runs = result.runs
    assert len(runs) == 4 and set(runs["mismatch"]) == {"aged"} and result.failures == {}
    assert isinstance(result.summary, pd.DataFrame) and len(result.summary) > 2
    assert told[0] == ("runs", 0.0) and told[-1] == ("runs", 1.0)
    assert "mle.study(campaign)" in result.report_html()
    assert "4 runs" in repr(result) and "<table" in result._repr_html_()
    assert pickle.loads(pickle.dumps(result)).runs.equals(runs)
    # In memory, with the file of the campaign: the same.
    again = mle.study(tmp_path / "campaign.json", figures=False)
    assert again.to_json() == result.to_json()


def test_what_is_wrong_with_a_campaign(loop, tmp_path):
    with pytest.raises(mle.InvalidInputError, match="campaign: .*seeds"):
        mle.study(campaign_of(loop, seeds=[]))
    with pytest.raises(TypeError, match="object cannot be written as JSON"):
        mle.study(campaign_of(loop, name=object()))
    with pytest.raises(FileNotFoundError, match="nowhere.json"):
        mle.study(tmp_path / "nowhere.json")
    with pytest.raises(ValueError, match="threads=-1"):
        mle.study(campaign_of(loop), threads=-1)
    with pytest.raises(TypeError, match="float"):
        mle.study(campaign_of(loop), threads=2.5)
    mle.study(campaign_of(loop), threads=2**31 - 1, figures=False)
    with pytest.raises(mle.FileAccessError, match="directory"):
        mle.study(tmp_path)
    mle.study(campaign_of(loop), out=tmp_path / "out", figures=False)
    with pytest.raises(mle.InvalidInputError, match="journal.csv.*resume"):
        mle.study(campaign_of(loop), out=tmp_path / "out")
    with pytest.raises(mle.InvalidInputError, match="journal.csv.*another campaign"):
        mle.study(campaign_of(loop, name="other"), out=tmp_path / "out", resume=True)


def test_stopped_study_resumes(loop, tmp_path):
    many = campaign_of(loop, seeds={"first": 1, "count": 200}, estimators=["none"])
    with pytest.raises(mle.CancelledError, match="resume=True"):
        mle.study(
            many, out=tmp_path, threads=1, figures=False, progress=lambda _, done: done == 0.0
        )
    done = (tmp_path / "journal.csv").read_text().splitlines()[2:]
    assert 0 < len(done) < 200
    whole = mle.study(many, out=tmp_path, resume=True, figures=False)
    assert len(whole.runs) == 200
    assert (tmp_path / "journal.csv").read_text().splitlines()[2 : 2 + len(done)] == done


INTERRUPTED = """
import os, signal, sys, threading, time
import mle
campaign = {
    "version": 1, "name": "long", "seeds": {"first": 1, "count": 100000},
    "models": [{"name": "random", "random": {"outputs": 2, "inputs": 2}}],
    "mismatches": [{"name": "none"}], "noise_variances": [1e-3], "estimators": ["none"],
}
asked = []
def interrupt():
    asked.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
def progress(stage, fraction):
    if not asked and fraction > 0:
        interrupt()
try:
    mle.study(campaign, threads=1, progress=progress)
    print("not interrupted")
except KeyboardInterrupt:
    print("interrupted")
"""


def test_keyboard_interrupt_stops_a_study(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert (done.stdout, done.returncode) == ("interrupted\n", 0), done.stderr
    assert os.listdir(tmp_path) == []  # nothing is left behind


AGEING = {
    "time_factor": 525960,
    "elements": [{"output": "level", "input": "valve", "gain": [[0, 1.0], [1, 0.6]]}],
}
LIFE = {
    "years": 0.5,
    "change_every": "30d",
    "sample_time": 1,
    "control_period": 2,
    "policies": "never,output_error:3,perfect",
    "seeds": 1,
    "figures": False,
}


def test_lifecycle_is_the_command(loop, tmp_path):
    model = loop[0]
    told = []
    result = mle.lifecycle(
        model, AGEING, progress=lambda stage, fraction: told.append(fraction), **LIFE
    )
    (tmp_path / "model.json").write_text(model.to_json())
    (tmp_path / "ageing.json").write_text(json.dumps(AGEING))
    flags = [f"--{name}={str(value).lower()}" for name, value in LIFE.items()]
    subprocess.run(
        [COMMANDS / "mle_lifecycle", f"--model={tmp_path}/model.json"]
        + [f"--ageing={tmp_path}/ageing.json", f"--out={tmp_path}/out", *flags],
        check=True,
        capture_output=True,
    )
    theirs = json.loads((tmp_path / "out" / "result.json").read_text())
    ours = result.to_dict()
    assert ours["rates"] == theirs["rates"]
    assert (tmp_path / "out" / "lifecycle.csv").read_text() == result._files["lifecycle.csv"]
    assert list(result.policies["policy"]) == ["never", "output_error:3", "perfect"]
    assert len(result.changes) > 6 and told[-1] == 1.0
    assert ours["command"].startswith("mle.lifecycle(model, ageing, years=0.5")
    with pytest.raises(mle.InvalidInputError, match="ageing"):
        mle.lifecycle(model, {"elements": 3}, **LIFE)
    with pytest.raises(TypeError, match="did you mean 'years'"):
        mle.lifecycle(model, AGEING, year=3)
