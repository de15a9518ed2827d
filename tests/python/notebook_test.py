"""The notebooks of python/notebooks, executed cell by cell."""

import json
import os
import pathlib

import matplotlib
import pytest

matplotlib.use("Agg")
NOTEBOOKS = pathlib.Path(os.environ["MLE_SOURCE"]) / "python" / "notebooks"


def execute(name):
    """What the names of the notebook stand for in the end."""
    cells = json.loads((NOTEBOOKS / name).read_text(encoding="utf-8"))["cells"]
    names = {}
    for number, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "notebooks are kept without outputs"
            exec(compile("".join(cell["source"]), f"{name}:{number}", "exec"), names)
    return names


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_tutorial(folder):
    names = execute("tutorial.ipynb")
    result = names["result"]
    assert result.decision == "corrected"
    aged = result.elements["aged"]
    assert list(aged) == [True, False, True, False]
    assert names["corrected"].static_gains[0, 0] == pytest.approx(6.4, rel=0.05)
    assert "<svg" in (folder / "page.html").read_text()
    assert len(names["figure"].axes) == 4


def test_closed_loop():
    names = execute("closed_loop.ipynb")
    assert names["result"].decision == "corrected"
    assert names["errors"]["corrected"] < names["errors"]["old"]
