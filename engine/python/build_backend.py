"""Builds the Python package with CMake: what pip calls (PEP 517).

pip builds in an environment of its own, into which it would have to download setuptools and pybind11. This needs only
Python, so that `pip install engine/python` works without a network where pybind11 is installed as a Debian package.

    --config-settings=build-dir=DIR    builds there, and again only what has changed; otherwise in a temporary folder
    CMAKE_ARGS                         further arguments for CMake, as "-DHANDHOLD_PLAN=OFF"
"""

import base64
import glob
import hashlib
import importlib.util
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

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def get_requires_for_build_wheel(config_settings=None):
    """What pip has to download: nothing where CMake and pybind11 are installed."""
    needs = []
    if not shutil.which("cmake"):
        needs.append("cmake>=3.25")
    installed = ("/usr", "/usr/local", sys.prefix)
    folders = ("lib/cmake", "lib/*/cmake", "share/cmake")
    configs = [f"{prefix}/{folder}/pybind11/pybind11Config.cmake" for prefix in installed for folder in folders]
    if not any(glob.glob(config) for config in configs):
        needs.append("pybind11>=2.10")
    return needs


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("the Python module is built from the whole repository: pip install PATH/engine/python")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    info = f"handhold-{project_version()}.dist-info"
    for name, content in metadata(info).items():
        path = pathlib.Path(metadata_directory, name)
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    return info


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version = project_version()
    name = f"handhold-{version}-{tag()}.whl"
    with tempfile.TemporaryDirectory(prefix="handhold-") as temporary:
        build = pathlib.Path((config_settings or {}).get("build-dir", f"{temporary}/build")).resolve()
        package = pathlib.Path(temporary, "package")
        run_cmake(build, package)
        wheel = pathlib.Path(temporary, name)
        write_wheel(wheel, package, f"handhold-{version}.dist-info")
        shutil.move(wheel, pathlib.Path(wheel_directory, name))
    return name


def project_version():
    return re.search(r"project\(handhold VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def run_cmake(build, package):
    if not shutil.which("cmake"):
        raise RuntimeError("there is no CMake; install cmake, g++ and the libraries that engine/python/README.md lists")
    arguments = [
        *(["-G", "Ninja"] if shutil.which("ninja") else []),
        "-DCMAKE_BUILD_TYPE=Release",
        "-DBUILD_SHARED_LIBS=OFF",
        "-DHANDHOLD_PYTHON=ON",
        "-DHANDHOLD_TOOLS=OFF",
        "-DHANDHOLD_TESTS=OFF",
        "-DHANDHOLD_BENCH=OFF",
        f"-DPython_EXECUTABLE={sys.executable}",
    ]
    pybind11 = importlib.util.find_spec("pybind11")
    if pybind11 and pybind11.origin:
        folder = pathlib.Path(pybind11.origin).parent / "share/cmake/pybind11"
        if folder.is_dir():
            arguments.append(f"-Dpybind11_DIR={folder}")
    arguments += shlex.split(os.environ.get("CMAKE_ARGS", ""))
    environment = {"CMAKE_BUILD_PARALLEL_LEVEL": str(os.cpu_count() or 1), **os.environ}
    for command in (
        ["cmake", "-S", ROOT, "-B", build, *arguments],
        ["cmake", "--build", build, "--target", "handhold_python"],
        ["cmake", "--install", build, "--component", "python", "--prefix", package],
    ):
        subprocess.run(command, check=True, env=environment)


def metadata(info):
    """The files of the folder `info` of a wheel, but for the list of all files."""
    return {
        f"{info}/METADATA": (
            "Metadata-Version: 2.1\n"
            "Name: handhold\n"
            f"Version: {project_version()}\n"
            "Summary: Finds the parts of objects that a robot hand can hold, in point clouds\n"
            "License: BSD-3-Clause\n"
            "Requires-Python: >=3.9\n"
            "Requires-Dist: numpy\n"
            "Description-Content-Type: text/markdown\n\n" + (HERE / "README.md").read_text(encoding="utf-8")
        ).encode(),
        f"{info}/LICENSE": (ROOT / "LICENSE").read_bytes(),
        f"{info}/WHEEL": (
            f"Wheel-Version: 1.0\nGenerator: handhold\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode()
        ),
    }


def write_wheel(path, package, info):
    files = {str(file.relative_to(package)): file.read_bytes() for file in sorted(package.rglob("*")) if file.is_file()}
    files.update(metadata(info))
    record = f"{info}/RECORD"
    lines = [f"{name},sha256={digest(content)},{len(content)}" for name, content in files.items()]
    files[record] = "\n".join([*lines, f"{record},,", ""]).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, content in files.items():
            wheel.writestr(name, content)


def digest(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
