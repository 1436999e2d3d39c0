"""Without the GIL: other threads run, one localizer serves one of them, cancel() reaches it."""

import threading
import time

import numpy as np
import pytest
from conftest import same

import handhold

LONG = {"samples": 5_000_000}  # seconds; each test ends it


class Search:
    """A long search in a thread of its own. Ended when the block is left, also by a failure."""

    def __init__(self, points, **options):
        self.localizer = handhold.Localizer(**{**LONG, **options})
        self.result = None
        self.thread = threading.Thread(target=self._run, args=(points,))

    def _run(self, points):
        self.result = self.localizer.localize(points)

    def __enter__(self):
        self.thread.start()
        # Only a localizer that has begun is busy.
        while True:
            try:
                self.localizer.samples()
            except RuntimeError:
                return self
            assert self.thread.is_alive()
            time.sleep(0.001)

    def cancel(self):
        # A cancel() between "busy" and the first look at the flag is lost: as long as it runs, again.
        while self.thread.is_alive():
            self.localizer.cancel()
            self.thread.join(0.01)

    def __exit__(self, *error):
        self.cancel()


def test_other_threads_run_meanwhile(table):
    with Search(table) as search:
        # Python code of this thread runs while the search is in progress: were the GIL held, none of it would before
        # the search is over.
        count = sum(1 for _ in range(100_000))
        assert search.thread.is_alive()
        assert handhold.localize(table[::8, ::8], samples=50).status == "ok"
        assert search.thread.is_alive()
    assert count == 100_000
    assert search.result.status == "cancelled"


def test_cancel(table):
    with Search(table) as search:
        search.cancel()
        assert not search.thread.is_alive()
    result = search.result
    assert result.status == "cancelled" and result.cut
    assert len(result.handles) == len(result.affordances) == 0
    assert result.points == table.size // 3
    # The next frame is not cancelled, nor is one after a cancel() between frames.
    localizer = handhold.Localizer(samples=300)
    localizer.cancel()
    assert same(localizer.localize(table), handhold.localize(table, samples=300))


def test_one_frame_at_a_time(table):
    with Search(table) as search:
        busy = "this localizer is busy with another thread's frame; make one for each thread"
        with pytest.raises(RuntimeError, match=busy):
            search.localizer.localize(table)
        with pytest.raises(RuntimeError, match=busy):
            search.localizer.set_seed(3)
        with pytest.raises(RuntimeError, match=busy):
            search.localizer.samples()
        assert search.localizer.options["samples"] == LONG["samples"]
    assert search.result.status == "cancelled"
    with pytest.raises(ValueError):
        search.localizer.localize(None)
    search.localizer.samples()  # free again


def test_many_threads_many_localizers(table, rod):
    clouds = [table, rod, table[::2, ::2], rod.astype(float)]
    options = {"samples": 300, "threads": 1}
    expected = [handhold.localize(cloud, **options) for cloud in clouds]
    failures = []

    def work(which):
        try:
            localizer = handhold.Localizer(**options)
            for i in range(8):
                at = (which + i) % len(clouds)
                result = localizer.localize(clouds[at])
                if not same(result, expected[at]):
                    failures.append(f"thread {which}, frame {i}: another result")
        except Exception as error:  # would be lost in the thread
            failures.append(f"thread {which}: {error!r}")

    threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []


def test_results_may_be_read_from_any_thread(table):
    localizer = handhold.Localizer(samples=500)
    result = localizer.localize(table)
    expected = result.to_dict()
    found = []

    def read():
        for _ in range(20):
            found.append(result.to_dict() == expected and np.isfinite(result.affordances.center).all())

    threads = [threading.Thread(target=read) for _ in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(5):
        localizer.localize(table)
    for thread in threads:
        thread.join()
    assert len(found) == 80 and all(found)
