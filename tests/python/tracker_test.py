"""Handles from frame to frame."""

import numpy as np
import pytest

import handhold


def handle(center, radius=0.015):
    return handhold.Handle(center, [0, 1, 0], [0, 0, 1], radius, 0.1, 0.9)


def test_who_is_who():
    tracker = handhold.Tracker()
    for frame in range(40):
        x = 0.01 * frame
        handles = [handle([x, 0, 0.8]), handle([x, 0.5, 0.8], 0.02)]
        tracks = tracker.update(handles[:: 1 if frame % 2 else -1])
        assert [t.id for t in tracks] == [1, 2]
        assert [(t.age, t.unseen) for t in tracks] == [(frame + 1, 0)] * 2
    radius = sorted(t.handle.radius for t in tracks)
    assert radius == pytest.approx([0.015, 0.02], abs=1e-4)
    assert tracks[0].velocity == pytest.approx([0.01, 0, 0], abs=1e-4)
    assert tracks[0].velocity.dtype == np.float64 and not tracks[0].velocity.flags.writeable


def test_tracks_are_snapshots():
    tracker = handhold.Tracker(keep=1)
    first = tracker.update([handle([0, 0, 0.8])])[0]
    text = repr(first.handle)
    for _ in range(3):
        tracker.update([])
    assert tracker.tracks == []
    assert repr(first.handle) == text and first.age == 1


def test_a_camera_that_moves():
    tracker = handhold.Tracker()
    tracker.update([handle([0, 0, 0.8])])
    T = np.eye(4)
    T[:3, 3] = [0.5, 0, 0]
    (track,) = tracker.update([handle([0.5, 0, 0.8])], T_now_last=T)
    assert track.id == 1 and track.velocity == pytest.approx([0, 0, 0], abs=1e-12)
    places = tracker.guesses(T_next_now=np.linalg.inv(T))
    assert places.shape[1] == 3 and np.abs(places[:, 0]).max() < 1e-6
    assert tracker.guesses()[:, 0] == pytest.approx(0.5)


def test_of_results(table):
    localizer, tracker = handhold.Localizer(samples=1000), handhold.Tracker()
    seen = []
    for frame in range(4):
        localizer.set_seed(frame)
        tracks = tracker.update(localizer.localize(table, guesses=tracker.guesses()).handles)
        seen.append({t.id for t in tracks if t.unseen == 0})
    assert seen[0] & seen[-1]
    assert len({t.id for t in tracks}) == len(tracks)


@pytest.mark.parametrize(
    "T",
    [np.eye(3), np.zeros((4, 4)), np.diag([1, 1, 1, 2]), np.diag([1, 1, -1, 1]), np.full((4, 4), np.nan), "x", 3,
     np.where(np.eye(4, k=3), np.inf, np.eye(4)), np.diag([2, 2, 2, 1])],
)
def test_what_is_no_motion(T):
    tracker = handhold.Tracker()
    with pytest.raises(ValueError, match="T_now_last = .*: must be a 4x4 matrix, a rotation and a translation"):
        tracker.update([], T_now_last=T)
    with pytest.raises(ValueError, match="T_next_now = "):
        tracker.guesses(T_next_now=T)


def test_what_is_no_handle_or_option():
    with pytest.raises(ValueError, match=r"handles\[1\] = 3: must be a handhold.Handle"):
        handhold.Tracker().update([handle([0, 0, 1]), 3])
    with pytest.raises(ValueError, match="handles = 3: must be Result.handles or a list of handhold.Handle"):
        handhold.Tracker().update(3)
    with pytest.raises(ValueError, match="weight = 0.*: must be"):
        handhold.Tracker(weight=0)
