"""Time of a call from Python beside the library's own: what the module adds to a frame.

    PYTHONPATH=build/release/engine/python /usr/bin/python3 bench/python_call.py [CLOUD.pcd] [--repeat N] [--samples N]

Every call tells in its result how long the library took; what is left of the wall-clock time is Python's. Compare the
library's time with `handhold localize CLOUD.pcd --samples N --repeat N`.
"""

import argparse
import pathlib
import statistics
import time

import numpy as np

import handhold


def measure(search, points, repeat):
    """Medians (ms): the whole call, the library's part, the difference."""
    calls, inside = [], []
    for frame in range(repeat + 5):
        start = time.perf_counter()
        result = search(points)
        call = 1e3 * (time.perf_counter() - start)
        if frame >= 5:  # memory is warm
            calls.append(call)
            inside.append(result.times_ms["total"])
    outside = [c - i for c, i in zip(calls, inside)]
    return statistics.median(calls), statistics.median(inside), statistics.median(outside)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    table = pathlib.Path(__file__).resolve().parent.parent / "data/table_scene.pcd"
    parser.add_argument("cloud", nargs="?", default=table, help="PCD or PLY file [data/table_scene.pcd]")
    parser.add_argument("--repeat", type=int, default=100, help="calls of which the median is taken")
    parser.add_argument("--samples", type=int, default=5000)
    arguments = parser.parse_args()

    points = handhold.read_cloud(arguments.cloud).points
    options = {"samples": arguments.samples}
    localizer = handhold.Localizer(**options)
    wide = np.full((*points.shape[:-1], 4), np.nan, np.float32)
    wide[..., :3] = points
    rows = [
        ("Localizer, no points", localizer.localize, points[:0, 0]),
        ("Localizer, float32", localizer.localize, points),
        ("Localizer, float32, every fourth value left out", localizer.localize, wide[..., :3]),
        ("Localizer, float32, Fortran order (copied)", localizer.localize, np.asfortranarray(points)),
        ("Localizer, float64 (copied)", localizer.localize, points.astype(float)),
        ("handhold.localize, float32", lambda p: handhold.localize(p, **options), points),
    ]
    print(f"{arguments.cloud}: {points.size // 3} points, {arguments.samples} samples, {handhold.isa()}")
    print(f"{'median of ' + str(arguments.repeat) + ' calls':50} call ms  library ms  Python us")
    for name, search, cloud in rows:
        call, library, python = measure(search, cloud, arguments.repeat)
        print(f"{name:50} {call:7.2f} {library:11.2f} {1e3 * python:10.1f}")
    result = localizer.localize(points)
    start = time.perf_counter()
    for _ in range(1000):
        result.handles.center, result.affordances.center, result.affordances.radius
    print(f"three arrays of a result: {1e3 * (time.perf_counter() - start):.1f} us")


if __name__ == "__main__":
    main()
