"""Makes a wheel of the Python package by CMake: the backend of pyproject.toml
(PEP 517), so that `pip install .` works without a network.

It takes nothing but Python itself, CMake, a compiler and what the libraries
need (docs/architecture.md); scikit-build-core and meson-python would have to be
downloaded, or be there in a version that fits. The compiled module is linked
with the project's libraries, and with the system's Ceres, Abseil and others.

    CMAKE_ARGS="-DMLE_WERROR=ON" pip install .     # more entries for the cache
"""

import base64
import hashlib
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
NAME = "model-life-extension"


def _version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(mle\s+VERSION ([0-9.]+)", text).group(1)


def _metadata():
    return "\n".join(
        [
            "Metadata-Version: 2.1",
            f"Name: {NAME}",
            f"Version: {_version()}",
            "Summary: Correct a process model from routine closed-loop records",
            "Requires-Python: >=3.9",
            "Requires-Dist: numpy",
            "Provides-Extra: frames",
            'Requires-Dist: pandas; extra == "frames"',
            "Provides-Extra: figures",
            'Requires-Dist: matplotlib; extra == "figures"',
            "",
        ]
    )


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def _pybind11_folder():
    """Where pip's pybind11 has its CMake package; none: the system's."""
    try:
        import pybind11
    except ImportError:
        return []
    return [f"-Dpybind11_DIR={pybind11.get_cmake_dir()}"]


def _build():
    """The folder in which the module is built."""
    build = ROOT / "build" / f"wheel-{_tag()}"
    generator = ["-GNinja"] if shutil.which("ninja") else []
    subprocess.run(
        ["cmake", "-S", ROOT, "-B", build, *generator]
        + ["-DCMAKE_BUILD_TYPE=Release", "-DBUILD_SHARED_LIBS=OFF"]
        + ["-DMLE_BUILD_PYTHON=ON", "-DMLE_BUILD_TESTS=OFF"]
        + [f"-DPython_EXECUTABLE={sys.executable}", "-DMLE_PYTHON_INSTALL_DIR=."]
        + _pybind11_folder()
        + shlex.split(os.environ.get("CMAKE_ARGS", "")),
        check=True,
    )
    _compile(
        ["cmake", "--build", build, "--target", "mle_python", "--parallel", str(os.cpu_count())]
    )
    return build


def _terminal():
    """Where progress is seen: pip keeps what a build prints to itself."""
    try:
        return open("/dev/tty", "w", encoding="utf-8")
    except OSError:
        return open(os.devnull, "w", encoding="utf-8")


def _compile(command):
    """Runs it, and tells the terminal every tenth of the targets."""
    told = 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as build, _terminal() as out:
        for line in build.stdout:
            print(line, end="", flush=True)
            step = re.match(r"\[ *(\d+)(?:/(\d+)|%)\]", line)
            share = step and int(step[1]) / int(step[2] or 100)
            if share and int(10 * share) > told:
                told = int(10 * share)
                print(f"\r{NAME}: {10 * told} % compiled", file=out, flush=True)
    if build.returncode:
        raise subprocess.CalledProcessError(build.returncode, command)


def _install(build, folder):
    """Installs the package of a build folder below `folder`."""
    subprocess.run(
        ["cmake", "--install", build, "--component", "python", "--strip", "--prefix", folder],
        check=True,
    )


def _info():
    return f"{NAME.replace('-', '_')}-{_version()}.dist-info"


def _files(folder):
    """Names and contents of all that the wheel holds, but for its list."""
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.is_file():
            yield path.relative_to(folder).as_posix(), path.read_bytes()
    info = _info()
    wheel = f"Wheel-Version: 1.0\nGenerator: mle\nRoot-Is-Purelib: false\nTag: {_tag()}\n"
    yield f"{info}/METADATA", _metadata().encode()
    yield f"{info}/WHEEL", wheel.encode()
    yield f"{info}/LICENSE", (ROOT / "LICENSE").read_bytes()


def _pack(folder, wheel_directory):
    """The name of the wheel of what `folder` holds."""
    name = f"{NAME.replace('-', '_')}-{_version()}-{_tag()}.whl"
    record = []
    path = pathlib.Path(wheel_directory) / name
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for member, content in _files(folder):
            wheel.writestr(member, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest())
            record.append(f"{member},sha256={digest.decode().rstrip('=')},{len(content)}")
        listed = f"{_info()}/RECORD"
        wheel.writestr(listed, "\n".join([*record, f"{listed},,", ""]))
    return name


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """The name of the folder with the metadata, for which nothing is built."""
    folder = pathlib.Path(metadata_directory) / _info()
    folder.mkdir()
    (folder / "METADATA").write_text(_metadata(), encoding="utf-8")
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """The name of the wheel that is written to `wheel_directory`."""
    build = _build()
    with tempfile.TemporaryDirectory() as folder:
        _install(build, folder)
        return _pack(folder, wheel_directory)


def build_sdist(sdist_directory, config_settings=None):
    """Not offered: the package is built in the project's tree."""
    raise NotImplementedError("a source distribution is the project's tree itself")
