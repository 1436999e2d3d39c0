"""Results as arrays and as objects."""

import copy
import json

import numpy as np
import pytest
from conftest import same

import handhold

SHAPES = {
    "handles": {
        "center": (3,), "axis": (3,), "approach": (3,), "radius": (), "length": (), "confidence": (), "arc": (),
        "residual": (), "observed_free": (), "normal_error": (), "path": ("P", 3), "affordances": ("A",),
    },
    "affordances": {
        "center": (3,), "axis": (3,), "normal": (3,), "radius": (), "shell_radius": (), "gap": (), "curvature": (),
        "observed_free": (), "quality": (), "neighbourhood": (), "sample": (),
    },
}
WHOLE = {"affordances", "sample"}


@pytest.fixture(scope="module")
def result(table):
    return handhold.localize(table)


@pytest.fixture(params=["handles", "affordances"])
def kind(request):
    return request.param


def test_arrays_of_all_and_values_of_one(result, kind):
    everything = getattr(result, kind)
    count = len(everything)
    assert count > 2
    for name, shape in SHAPES[kind].items():
        column = getattr(everything, name)
        dtype = np.uint32 if name in WHOLE else np.float64
        if shape and isinstance(shape[0], str):
            assert isinstance(column, tuple) and len(column) == count
            for element, array in zip(everything, column):
                assert array.dtype == dtype and array.ndim == len(shape) and array.shape[1:] == shape[1:]
                assert np.array_equal(getattr(element, name), array)
                assert not array.flags.writeable
            continue
        assert column.shape == (count, *shape) and column.dtype == dtype
        assert not column.flags.writeable
        for i, element in enumerate(everything):
            value = getattr(element, name)
            assert np.array_equal(value, column[i])
            if shape:
                assert value.shape == shape and value.dtype == dtype and not value.flags.writeable
            else:
                assert type(value) is (int if name in WHOLE else float)


def test_what_the_numbers_mean(result):
    handles, affordances = result.handles, result.affordances
    for unit in handles.axis, handles.approach, affordances.axis, affordances.normal:
        assert np.linalg.norm(unit, axis=1) == pytest.approx(1)
    assert (np.diff(handles.confidence) <= 0).all()
    assert (np.diff(affordances.sample.astype(int)) >= 0).all()
    for indices in handles.affordances:
        assert (np.diff(indices.astype(int)) > 0).all() and indices[-1] < len(affordances)
    assert sum(len(path) > 0 for path in handles.path) > 0, "no curved handle: its path is not tested"


def test_sequences(result, kind):
    everything = getattr(result, kind)
    elements = list(everything)
    type_name = {"handles": handhold.Handle, "affordances": handhold.Affordance}[kind]
    assert all(type(e) is type_name for e in elements)
    centers = [tuple(e.center) for e in elements]
    assert tuple(everything[0].center) == centers[0]
    assert tuple(everything[-1].center) == centers[-1]
    assert [tuple(e.center) for e in everything[1:3]] == centers[1:3]
    assert [tuple(e.center) for e in everything[::-1]] == centers[::-1]
    assert everything[5:2] == []
    for i in len(elements), -len(elements) - 1:
        with pytest.raises(IndexError):
            everything[i]
    with pytest.raises(TypeError):
        everything["center"]


def test_empty_ones_have_their_shapes(kind):
    everything = getattr(handhold.localize(np.zeros((0, 3))), kind)
    assert len(everything) == 0 and list(everything) == [] and not everything
    for name, shape in SHAPES[kind].items():
        column = getattr(everything, name)
        if shape and isinstance(shape[0], str):
            assert column == ()
        else:
            assert column.shape == (0, *shape)


def test_arrays_cannot_be_written(result):
    for array in result.handles.center, result.handles[0].center, result.affordances.sample:
        with pytest.raises(ValueError):
            array[:] = 0
        with pytest.raises(ValueError):
            array.flags.writeable = True
    mine = result.handles.center.copy()
    mine[:] = 0
    assert result.handles.center.any()


def test_nothing_can_be_set(result):
    for thing, name in (result, "status"), (result.handles, "center"), (result.handles[0], "radius"):
        with pytest.raises(AttributeError):
            setattr(thing, name, 1)


def test_to_dict_is_json(result):
    whole = result.to_dict()
    assert json.loads(json.dumps(whole, allow_nan=False)) == whole
    assert list(whole) == ["status", "points", "finite_points", "funnel", "times_ms", "handles", "affordances"]
    assert whole["handles"] == [h.to_dict() for h in result.handles]
    assert list(whole["handles"][0]) == list(SHAPES["handles"])
    assert list(whole["affordances"][0]) == list(SHAPES["affordances"])
    for name in SHAPES["handles"]:
        assert whole["handles"][0][name] == np.asarray(getattr(result.handles[0], name)).tolist()


def test_funnel_adds_up(result):
    funnel = result.funnel
    steps = list(funnel)[1 : list(funnel).index("cut") + 1]
    assert [{"affordances": "affordance"}.get(step, step) for step in steps] == list(handhold.STEPS)
    assert sum(funnel[step] for step in steps) == funnel["samples"] == 5000
    assert funnel["affordances"] == len(result.affordances)
    assert all(type(count) is int for count in funnel.values())
    funnel["flat"] = -1
    assert result.funnel["flat"] >= 0


def test_times(result):
    times = result.times_ms
    total = times.pop("total")
    assert total > 0
    assert all(0 <= stage <= total for stage in times.values())


def test_how_they_are_shown(result):
    handle = result.handles[0]
    assert f"{result.status}, {len(result.handles)} handles, {len(result.affordances)} affordances" in repr(result)
    assert repr(handle).startswith("Handle(center=(") and f"radius={handle.radius:.4g}" in repr(handle)
    assert repr(result.affordances[0]).startswith("Affordance(center=(")
    assert repr(result.handles) == f"<Handles: {len(result.handles)}>"


def test_a_handle_made_by_hand():
    handle = handhold.Handle([0, 1, 2], np.array([1, 0, 0]), (0, 0, 1), 0.02, length=0.1, path=np.ones((4, 3)))
    assert handle.center.tolist() == [0, 1, 2] and handle.axis.tolist() == [1, 0, 0]
    assert (handle.radius, handle.length, handle.confidence) == (0.02, 0.1, 1)
    assert handle.path.shape == (4, 3) and handle.affordances.shape == (0,)
    for bad, message in (
        ({"center": [0, 1]}, "center = .*: must be three numbers"),
        ({"axis": "x"}, "axis = 'x': must be three numbers"),
        ({"radius": "2 cm"}, "radius = '2 cm': must be a number"),
        ({"path": [[0, 1]]}, "path = .*: must be three numbers"),
    ):
        good = {"center": [0, 0, 0], "axis": [1, 0, 0], "approach": [0, 0, 1], "radius": 0.02, "length": 0.1}
        with pytest.raises(ValueError, match=message):
            handhold.Handle(**{**good, **bad})


def test_no_copy_or_pickle_that_lies(result):
    with pytest.raises(TypeError):
        copy.deepcopy(result)
    assert copy.deepcopy(result.to_dict()) == result.to_dict()


def test_only_the_library_makes_results():
    for made in handhold.Result, handhold.Handles, handhold.Affordances, handhold.Affordance, handhold.Track:
        with pytest.raises(TypeError, match="No constructor defined"):
            made()


def test_same_tells_a_difference(table, result):
    assert same(result, handhold.localize(table))
    assert not same(result, handhold.localize(table, samples=4999))
