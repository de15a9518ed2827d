"""Records and models that the tests share, and the commands to be compared with."""

import json
import os
import pathlib
import subprocess

import pytest

import mle

COMMANDS = pathlib.Path(os.environ["MLE_COMMANDS"])
CONFIGS = pathlib.Path(os.environ["MLE_SOURCE"]) / "configs"


@pytest.fixture(scope="session")
def configs():
    return CONFIGS


@pytest.fixture(scope="session")
def source():
    return CONFIGS.parent


@pytest.fixture(scope="session")
def loop():
    """A small loop: (model, plant that has aged, record of both)."""
    names = {"inputs": ["valve"], "outputs": ["level"]}
    model = mle.from_fopdt([[2.0]], 10.0, 2.0, **names)
    plant = mle.from_fopdt([[2.6]], 13.0, 2.0, **names)
    record = mle.simulate(
        model,
        plant,
        setpoints=[("level", 60, 1.0), ("level", 180, -0.5)],
        duration=300,
        sample_time=1.0,
        control_period=2,
        noise_variance=1e-4,
        seed=3,
    )
    return model, plant, record


@pytest.fixture
def frame(loop):
    """The loop's record as a data frame with dates, fresh for each test."""
    model, _, record = loop
    return mle.to_dataframe(record, model, start="2024-03-04 06:00")


@pytest.fixture(scope="session")
def run_correct(tmp_path_factory):
    """result.json that mle_correct writes with these flags."""

    def run(model, data, *flags):
        folder = tmp_path_factory.mktemp("command")
        done = subprocess.run(
            [COMMANDS / "mle_correct", f"--model={model}", f"--data={data}", f"--out={folder}"]
            + ["--figures=false", *flags],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode in (0, 1), done.stderr
        return json.loads((folder / "result.json").read_text())

    return run
