"""Finds the parts of objects that a robot hand can hold, in the point clouds of depth cameras.

    result = handhold.localize(points)          # float32 or float64, (N, 3) or (H, W, 3), metres
    for h in result.handles:
        print(h.center, h.axis, h.radius)       # m, unit vector, m
    result.handles.center                       # the same of all: (N, 3)

Everything is in metres and radians, in the frame of the cloud. What cannot be used raises ValueError with one line:
what is wrong, and what would be right.
"""

from ._core import (
    STEPS,
    Affordance,
    Affordances,
    CudaDevice,
    Handle,
    Handles,
    Localizer,
    Result,
    Track,
    Tracker,
    __version__,
    cuda_device,
    isa,
    localize,
    options,
    to_toml,
)
from ._files import Cloud, read_cloud

for _public in (Cloud, read_cloud):
    _public.__module__ = __name__

__all__ = [
    "STEPS",
    "Affordance",
    "Affordances",
    "Cloud",
    "CudaDevice",
    "Handle",
    "Handles",
    "Localizer",
    "Result",
    "Track",
    "Tracker",
    "__version__",
    "cuda_device",
    "isa",
    "localize",
    "options",
    "read_cloud",
    "to_toml",
]
