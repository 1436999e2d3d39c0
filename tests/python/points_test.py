"""Arrays of every layout give the same result; what is no cloud is refused with one line."""

import ctypes
import mmap

import numpy as np
import pytest
from conftest import same
from numpy.lib.recfunctions import structured_to_unstructured

import handhold

OPTIONS = {"samples": 300, "hand_aperture": 0.1}


@pytest.fixture(scope="module")
def expected(rod):
    return handhold.localize(rod, **OPTIONS)


def fortran(points):
    return np.asfortranarray(points)


def padded(points):
    """x, y, z and a fourth value, as PCL has them: a view of the first three."""
    wide = np.full((*points.shape[:-1], 4), np.nan, points.dtype)
    wide[..., :3] = points
    return wide[..., :3]


def every_other(points):
    wide = np.full((*points.shape[:-2], 2 * points.shape[-2], 3), np.nan, points.dtype)
    wide[..., ::2, :] = points
    return wide[..., ::2, :]


def cropped(points):
    """Rows that are farther apart than they are long."""
    wide = np.full((*points.shape[:-2], points.shape[-2] + 5, 3), np.nan, points.dtype)
    wide[..., 2:-3, :] = points
    return wide[..., 2:-3, :]


def reversed_memory(points):
    return np.ascontiguousarray(points[..., ::-1, :])[..., ::-1, :]


def reversed_coordinates(points):
    return np.ascontiguousarray(points[..., ::-1])[..., ::-1]


def swapped(points):
    return points.astype(points.dtype.newbyteorder())


def misaligned(points):
    memory = np.zeros(points.nbytes + 1, np.uint8)
    memory[1:] = np.frombuffer(points.tobytes(), np.uint8)
    array = np.ndarray(points.shape, points.dtype, memory, 1)
    assert not array.flags.aligned
    return array


def odd_step(points):
    """Points 13 or 25 bytes apart, in a packed record."""
    record = np.zeros(points.shape[:-1], np.dtype([("xyz", points.dtype, 3), ("label", np.uint8)]))
    record["xyz"] = points
    return record["xyz"]


def fields(points):
    record = np.zeros(points.shape[:-1], np.dtype([(name, points.dtype) for name in ("x", "y", "z", "intensity")]))
    record["x"], record["y"], record["z"] = np.moveaxis(points, -1, 0)
    return structured_to_unstructured(record[["x", "y", "z"]])


def planes(points):
    """x, y, z each an image of its own."""
    return np.moveaxis(np.ascontiguousarray(np.moveaxis(points, -1, 0)), 0, -1)


def same_array(points):
    return points


LAYOUTS = [
    same_array,
    fortran,
    padded,
    every_other,
    cropped,
    reversed_memory,
    reversed_coordinates,
    swapped,
    misaligned,
    odd_step,
    fields,
    planes,
]


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("organized", [True, False])
def test_layouts(rod, expected, layout, dtype, organized):
    points = layout((rod if organized else rod.reshape(-1, 3)).astype(dtype))
    assert np.array_equal(points, rod if organized else rod.reshape(-1, 3))
    right = expected if organized else handhold.localize(rod.reshape(-1, 3), **OPTIONS)
    assert len(right.handles) == 1
    localizer = handhold.Localizer(**OPTIONS)
    for _ in range(2):
        assert same(localizer.localize(points), right)


def test_neither_copied_nor_changed_nor_kept(rod):
    """Of memory that cannot be written, and is gone after the call."""
    memory = mmap.mmap(-1, rod.nbytes)
    memory[:] = rod.tobytes()
    points = np.frombuffer(memory, np.float32).reshape(rod.shape)
    points.flags.writeable = False
    before = points.tobytes()
    result = handhold.localize(points, **OPTIONS)
    assert points.tobytes() == before
    del points
    memory.close()  # raises when anything still points into it
    assert len(result.handles) == 1 and result.handles[0].center[2] > 0


@pytest.mark.parametrize("layout, copied", [(same_array, 0), (padded, 0), (every_other, 0), (fortran, 1), (planes, 1)])
def test_only_the_layouts_that_must_are_copied(rod, layout, copied):
    """A localizer that copies has memory for it: the C library's own count tells."""

    class Mallinfo(ctypes.Structure):
        _fields_ = [(name, ctypes.c_size_t) for name in "arena a b c hblkhd d e uordblks f keepcost".split()]

    libc = ctypes.CDLL(None)
    if not hasattr(libc, "mallinfo2"):
        pytest.skip("no mallinfo2")
    libc.mallinfo2.restype = Mallinfo

    def in_use():
        info = libc.mallinfo2()
        return info.uordblks + info.hblkhd

    points = layout(np.repeat(rod[np.newaxis], 4, axis=0).reshape(-1, *rod.shape[1:]))
    copy = np.ascontiguousarray(points)
    bytes_of_copy = points.size * 4
    assert bytes_of_copy > 200_000
    localizer = handhold.Localizer(samples=10, threads=1, index="grid")
    for _ in range(5):
        localizer.localize(copy)
    before = in_use()
    localizer.localize(points)
    grown = in_use() - before
    assert abs(grown - copied * bytes_of_copy) < 0.25 * bytes_of_copy


@pytest.mark.parametrize(
    "points",
    [
        np.arange(9, dtype=np.float32).reshape(3, 3).tolist(),
        tuple(map(tuple, np.arange(9.0).reshape(3, 3))),
        memoryview(np.arange(9.0).reshape(3, 3)),
    ],
)
def test_what_numpy_makes_an_array_of(points):
    assert handhold.localize(points).points == 3


def test_an_object_with_array(rod, expected):
    class Cloud:
        def __array__(self, dtype=None):
            return rod

    assert same(handhold.localize(Cloud(), **OPTIONS), expected)


MUST_SHAPE = r": must be \(N, 3\), or \(H, W, 3\) for an image"


@pytest.mark.parametrize(
    "points, message",
    [
        (np.zeros(3), r"points: shape \(3,\)" + MUST_SHAPE),
        (np.zeros(()), r"points: shape \(\)" + MUST_SHAPE),
        (np.zeros((3, 2)), r"points: shape \(3, 2\)" + MUST_SHAPE),
        (np.zeros((3, 0)), r"points: shape \(3, 0\)" + MUST_SHAPE),
        (np.zeros((3, 8)), r"points: shape \(3, 8\)" + MUST_SHAPE + r" \(of x, y, z and more: points\[..., :3\]\)"),
        (np.zeros((2, 2, 2, 3)), r"points: shape \(2, 2, 2, 3\)" + MUST_SHAPE),
        (np.zeros((4, 3), np.int32), "points: dtype int32: must be float32 or float64, in metres"),
        (np.zeros((4, 3), np.uint16), r"points: dtype uint16: .* \(of whole millimetres: points \* 0.001\)"),
        (np.zeros((4, 3), np.float16), "points: dtype float16: must be"),
        (np.zeros((4, 3), np.longdouble), "points: dtype float128: must be"),
        (np.zeros((4, 3), complex), "points: dtype complex128: must be"),
        (np.zeros((4, 3), bool), "points: dtype bool: must be"),
        (np.zeros((4, 3), object), "points: dtype object: must be"),
        (np.zeros(4, np.dtype([("x", "f4"), ("y", "f4"), ("z", "f4")])), "points: dtype .*structured_to_unstructured"),
        (np.ma.masked_array(np.zeros((4, 3))), "points: a masked array: .*filled"),
        ("cloud.pcd", "points: dtype <U9: must be"),
        (None, "points: dtype object: must be"),
        ([[1, 2, 3], [4, 5]], "inhomogeneous"),
        (np.broadcast_to(np.float32(0), (2**31, 3)), r"points: shape \(2147483648, 3\): must be fewer than 2\^31"),
        (np.broadcast_to(np.float32(0), (2**30, 2**20, 3)), "must be fewer than"),
    ],
)
def test_what_is_no_cloud(points, message):
    for search in handhold.localize, handhold.Localizer().localize:
        with pytest.raises(ValueError, match=message) as error:
            search(points)
        assert "\n" not in str(error.value)


def test_a_localizer_survives_what_it_refuses(rod, expected):
    localizer = handhold.Localizer(**OPTIONS)
    with pytest.raises(ValueError):
        localizer.localize(np.zeros((3, 2)))
    with pytest.raises(ValueError):
        localizer.localize(rod, viewpoint=(0, 0, np.inf))
    assert same(localizer.localize(rod), expected)
