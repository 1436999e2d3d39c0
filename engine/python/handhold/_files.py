"""Clouds from files, where the build has PCL."""

from typing import NamedTuple


class Cloud(NamedTuple):
    """A cloud from a file: handhold.localize(cloud.points, viewpoint=cloud.viewpoint).

    points: float32, (N, 3) or, organized, (H, W, 3); metres; NaN where nothing was measured
    rgb: uint8, of the same shape; None: the file has no colours
    viewpoint: where the sensor stood (m)
    """

    points: object
    rgb: object
    viewpoint: object


def read_cloud(path):
    """Reads a PCD or PLY file and returns a Cloud. Other Python threads run meanwhile.

    Raises ValueError for a file that is not there, damaged or of another kind, ImportError in a build without PCL.
    """
    try:
        from . import _io
    except ImportError as error:
        raise ImportError(
            "handhold.read_cloud: this build has no PCL, or it is gone; install libpcl-dev, then handhold again"
        ) from error
    return Cloud(*_io.read_cloud(path))
