"""The package as pip installs it, and its type stubs."""

import ast
import importlib.util
import inspect
import os
import pathlib
import subprocess
import sys
import venv

import pytest

import mle

SOURCE = pathlib.Path(os.environ["MLE_SOURCE"])
PACKAGE = pathlib.Path(mle.__file__).parent


@pytest.fixture(scope="module")
def backend():
    spec = importlib.util.spec_from_file_location("backend", SOURCE / "python" / "backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_wheel_installs_into_a_fresh_environment(backend, tmp_path):
    """All of `pip install .` but the compilation: the module is that of the build."""
    build = PACKAGE.parent.parent
    backend._install(build, tmp_path / "installed")
    (package,) = (tmp_path / "installed").rglob("mle")
    name = backend._pack(package.parent, tmp_path)
    venv.create(tmp_path / "venv", system_site_packages=True)
    python = tmp_path / "venv" / "bin" / "python"
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    # Where the build's libraries are shared, as no wheel's are.
    subprocess.run(
        ["cmake", "--install", build, "--component", "library", "--prefix", tmp_path / "shared"],
        check=True,
    )
    environment["LD_LIBRARY_PATH"] = ":".join(
        sorted({str(library.parent) for library in (tmp_path / "shared").rglob("libmle_*")})
    )

    def run(*command):
        return subprocess.run(
            [python, *command], capture_output=True, text=True, check=True, env=environment
        ).stdout

    run("-m", "pip", "install", "--no-index", "--no-deps", tmp_path / name)
    code = "import mle; print(mle.__file__, mle.from_fopdt([[1]], 2).settling_time)"
    file, settling_time = run("-c", code).split()
    assert file.startswith(str(tmp_path / "venv")) and float(settling_time) == 10.0
    shown = run("-m", "pip", "show", "--files", "model-life-extension")
    assert f"Version: {mle.__version__}" in shown
    for part in ("mle/_mle.pyi", "mle/py.typed", "mle/model.py"):
        assert part in shown


def test_metadata_need_no_build(backend, tmp_path):
    folder = backend.prepare_metadata_for_build_wheel(tmp_path)
    text = (tmp_path / folder / "METADATA").read_text(encoding="utf-8")
    assert f"Version: {mle.__version__}\n" in text and "Requires-Dist: numpy\n" in text


def test_compilation_that_fails_is_an_error(backend, capfd):
    backend._compile(["printf", "[1/2] one\n[2/2] two\n"])
    assert capfd.readouterr().out == "[1/2] one\n[2/2] two\n"
    with pytest.raises(subprocess.CalledProcessError):
        backend._compile(["false"])


def members(node):
    """Names that a class or module of the stubs has, without private types."""
    names = set()
    for child in node.body:
        if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
            names.add(child.name)
        elif isinstance(child, ast.AnnAssign):
            names.add(child.target.id)
    return names


def public(names):
    return {name for name in names if not name.startswith("__")}


def test_stubs_name_what_is_compiled():
    stubs = ast.parse((PACKAGE / "_mle.pyi").read_text(encoding="utf-8"))
    assert public(members(stubs)) == public(dir(mle._mle))
    for child in stubs.body:
        if isinstance(child, ast.ClassDef):
            compiled = getattr(mle._mle, child.name)
            assert public(members(child)) == public(dir(compiled)), child.name


def test_everything_public_is_documented():
    for name in mle.__all__:
        thing = getattr(mle, name)
        if not name.startswith("__"):
            assert thing.__doc__, name
        if inspect.isclass(thing):
            for member in public(vars(thing)):
                if not member.startswith("_") and callable(getattr(thing, member)):
                    assert getattr(thing, member).__doc__, f"{name}.{member}"


def test_page_of_the_api_is_up_to_date():
    made = subprocess.run(
        [sys.executable, SOURCE / "scripts" / "python_api_page"],
        capture_output=True,
        encoding="utf-8",
        check=True,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    ).stdout
    assert made == (SOURCE / "docs" / "python_api.md").read_text(encoding="utf-8")


def test_modules_are_all_installed():
    """What lies in the folder is in the list of what is installed."""
    listed = (SOURCE / "python" / "CMakeLists.txt").read_text(encoding="utf-8")
    for path in (SOURCE / "python" / "mle").glob("*.py*"):
        assert path.name in listed, path.name
