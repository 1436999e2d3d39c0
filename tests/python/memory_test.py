"""Results stay what they are, memory is used again, and nothing leaks."""

import ctypes
import gc
import sys
import weakref

import numpy as np
import pytest
from conftest import same

import handhold


def address(array):
    return array.__array_interface__["data"][0]


def in_use():
    """Bytes that the C library has handed out."""

    class Mallinfo(ctypes.Structure):
        _fields_ = [(name, ctypes.c_size_t) for name in "arena a b c hblkhd d e uordblks f keepcost".split()]

    libc = ctypes.CDLL(None)
    libc.mallinfo2.restype = Mallinfo
    info = libc.mallinfo2()
    return info.uordblks + info.hblkhd


def test_a_result_never_changes(table, rod):
    localizer = handhold.Localizer(samples=500)
    results, copies = [], []
    for cloud in table, rod, table[::2, ::2], rod[::2]:
        results.append(localizer.localize(cloud))
        copies.append(results[-1].to_dict())
    for _ in range(5):
        localizer.localize(table)
        localizer.localize(rod)
    assert [result.to_dict() for result in results] == copies


def test_an_array_keeps_what_it_shows(table):
    localizer = handhold.Localizer(samples=500)
    result = localizer.localize(table)
    views = [
        result.affordances.center,
        result.handles.radius,
        result.handles[0].center,
        result.handles.affordances[0],
        result.affordances[0].normal,
        localizer.samples()[0],
    ]
    handle = result.handles[0]
    kept = [view.copy() for view in views]
    text = repr(handle)
    del result
    for _ in range(5):
        localizer.localize(table[::2])
    del localizer
    gc.collect()
    assert all(np.array_equal(a, b) for a, b in zip(views, kept))
    assert repr(handle) == text


def test_the_memory_of_results_is_used_again(table):
    localizer = handhold.Localizer(samples=500)
    seen = set()
    for _ in range(20):
        result = localizer.localize(table)  # the last frame's is still there
        seen.add(address(result.affordances.center))
    assert len(seen) == 2
    # As soon as an array of it is kept, it is not.
    center = result.affordances.center
    before = center.copy()
    for _ in range(5):
        result = localizer.localize(table[::2])
        assert address(result.affordances.center) != address(center)
    assert np.array_equal(center, before)


def test_a_localizer_lets_go_of_results_that_are_kept(table):
    """It remembers a few, whatever Python does with them."""
    localizer = handhold.Localizer(samples=500)
    many = [localizer.localize(table) for _ in range(20)]
    assert len({address(result.affordances.center) for result in many}) == 20
    assert all(same(result, many[0]) for result in many)


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="the C library does not count")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_after_some_frames_nothing_is_allocated(table, dtype):
    """With the grid: Embree allocates for its trees."""
    points = table.astype(dtype)
    localizer = handhold.Localizer(samples=500, index="grid", threads=1)
    result = None
    for _ in range(20):
        result = localizer.localize(points)
    before = in_use()
    for _ in range(50):
        result = localizer.localize(points)
    assert abs(in_use() - before) < 4096
    assert len(result.handles) > 0


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="the C library does not count")
def test_no_leak(table, rod):
    """Of everything that the module does, also of what fails. A leak of one small object a round would show."""
    small = np.ascontiguousarray(table[::8, ::8])
    tracker = handhold.Tracker()

    def everything():
        localizer = handhold.Localizer(samples=50, threads=1, index="grid", radius=[0.01, 0.02])
        result = localizer.localize(small)
        localizer.localize(small.astype(float))
        [h.to_dict() for h in handhold.localize(rod, samples=50, threads=1, index="grid", hand_aperture=0.1).handles]
        result.to_dict(), result.affordances.center, result.affordances[:], localizer.samples(), repr(result)
        result.funnel, result.times_ms, localizer.options, handhold.to_toml(), result.handles.path
        handle = handhold.Handle([0, 0, 1], [1, 0, 0], [0, 0, 1], 0.01, 0.1, path=[[0, 0, 1]] * 9)
        tracker.update([handle]), tracker.guesses(), [t.handle.center for t in tracker.tracks]
        for bad in ({"radius": "x"}, {"radiuss": 1}, {"config": "/nothing"}, {"samples": 0}):
            with pytest.raises(ValueError):
                handhold.Localizer(**bad)
        for points in (np.zeros((3, 4)), np.zeros((3, 3), int), [[1], [2, 3]], None):
            with pytest.raises(ValueError):
                localizer.localize(points)
        with pytest.raises(ValueError):
            tracker.update([3])

    for _ in range(30):
        everything()
    gc.collect()
    before = in_use()
    rounds = 200
    for _ in range(rounds):
        everything()
    gc.collect()
    assert in_use() - before < 16 * rounds


def test_references_are_given_back(rod):
    points = np.array(rod)
    double = points.astype(float)
    path = "/nothing/here.toml"
    key = weakref.ref(points)
    localizer = handhold.Localizer(samples=50)
    counted = (points, double, path, handhold.Result, handhold.Handle, localizer)
    localizer.localize(points)
    before = [sys.getrefcount(thing) for thing in counted]
    for _ in range(50):
        result = localizer.localize(points)
        localizer.localize(double)
        with pytest.raises(ValueError):
            localizer.localize(points, viewpoint=3)
        with pytest.raises(ValueError):
            handhold.localize(points, config=path)
        list(result.handles), result.affordances.center
        del result
    assert [sys.getrefcount(thing) for thing in counted] == before
    del points, counted
    assert key() is None
