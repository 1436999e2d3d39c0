"""Clouds for the tests of the Python module."""

import os
import pathlib

import numpy as np
import pytest

import handhold

SOURCE = pathlib.Path(os.environ["HANDHOLD_SOURCE"])


@pytest.fixture(scope="session")
def table():
    """The depth image of data/: (480, 640, 3) float32, NaN where nothing was measured."""
    points = handhold.read_cloud(SOURCE / "data/table_scene.pcd").points
    points.flags.writeable = False
    return points


@pytest.fixture(scope="session")
def rod():
    """A rod of 50 mm across and 300 mm long, 0.7 m before the sensor, its near side: (150, 36, 3) float32."""
    x, angle = np.meshgrid(np.arange(-0.15, 0.15, 0.002), np.arange(-1.4, 1.4, 0.08), indexing="ij")
    points = np.stack([x, 0.025 * np.sin(angle), 0.7 - 0.025 * np.cos(angle)], axis=-1).astype(np.float32)
    points.flags.writeable = False
    return points


def same(a, b):
    """Whether two results have the same bits, but for the times."""
    a, b = a.to_dict(), b.to_dict()
    del a["times_ms"], b["times_ms"]
    return a == b
