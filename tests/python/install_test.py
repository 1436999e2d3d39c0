"""pip installs the package into a virtual environment, without a network, as the README says."""

import os
import pathlib
import re
import subprocess
import sys

import pytest
from conftest import SOURCE

FOLDER = SOURCE / "engine/python"

# What one does with it after that, away from the sources.
USE = """
import pathlib, sys
import numpy as np
import handhold
package = pathlib.Path(handhold.__file__).parent
assert pathlib.Path(sys.prefix) in package.parents, package
assert {"__init__.pyi", "py.typed", "plan.pyi"} <= {file.name for file in package.iterdir()}
x, angle = np.meshgrid(np.arange(-0.15, 0.15, 0.002), np.arange(-1.4, 1.4, 0.08))
rod = np.stack([x, 0.025 * np.sin(angle), 0.7 - 0.025 * np.cos(angle)], axis=-1)
assert len(handhold.localize(rod, hand_aperture=0.1).handles) == 1
for what in (lambda: handhold.read_cloud("cloud.pcd"), lambda: __import__("handhold.plan")):
    try:
        what()
    except ImportError as error:
        print(error)
print(handhold.__version__)
"""


def run(*command, folder, **variables):
    """Its output. Without what this test's own environment has."""
    ours = ("PYTHON", "PIP_", "HANDHOLD_", "CMAKE_ARGS")
    environment = {name: value for name, value in os.environ.items() if not name.startswith(ours)}
    # No index: what would have to be downloaded is an error.
    environment.update({"PYTHONDONTWRITEBYTECODE": "1", "PIP_NO_INDEX": "1"})
    environment.update({"PIP_CONFIG_FILE": os.devnull, "PIP_NO_CACHE_DIR": "1"}, **variables)
    done = subprocess.run([str(part) for part in command], cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout[-6000:]
    return done.stdout


def files_of_source():
    return sorted(str(file) for file in FOLDER.rglob("*"))


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return tmp_path_factory.mktemp("build")


def venv(folder):
    run(sys.executable, "-m", "venv", "--system-site-packages", folder / "venv", folder=folder)
    return folder / "venv/bin/python"


@pytest.mark.parametrize(
    "where, what, flags",
    [
        (FOLDER, ".", []),
        (SOURCE, "engine/python", []),
        (SOURCE, FOLDER, ["--no-build-isolation", "--no-deps"]),
    ],
)
def test_pip_install(tmp_path, build, where, what, flags):
    """Of a small build: with neither a planner nor PCL, which say so. -O1 compiles in a quarter of the time."""
    before = files_of_source()
    python = venv(tmp_path)
    cmake = "-DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS=-O1 -DHANDHOLD_PLAN=OFF -DCMAKE_DISABLE_FIND_PACKAGE_PNG=ON"
    run(python, "-m", "pip", "install", f"--config-settings=build-dir={build}", *flags, what, folder=where,
        CMAKE_ARGS=cmake)
    assert files_of_source() == before, "pip has left something among the sources"
    version = re.search(r"project\(handhold VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())[1]
    *told, last = run(python, "-c", USE, folder=tmp_path).splitlines()
    assert last == version
    assert len(told) == 2 and "no PCL" in told[0] and "no planner" in told[1]
    assert re.search("^Requires: numpy$", run(python, "-m", "pip", "show", "handhold", folder=tmp_path), re.M)
    run(python, "-m", "pip", "uninstall", "-y", "handhold", folder=tmp_path)
    assert not list(pathlib.Path(tmp_path, "venv").rglob("handhold*"))


def test_the_readme_names_the_packages_that_the_tests_are_run_with():
    """Two lists of packages must not drift apart."""
    (line,) = re.findall(r"^sudo apt-get install (.*)$", (FOLDER / "README.md").read_text(), re.M)
    setup = (SOURCE / "tools/setup").read_text()
    for package in line.split():
        assert re.search(rf"[\s(]{re.escape(package)}[\s)]", setup), f"tools/setup does not install {package}"
