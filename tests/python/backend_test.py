"""What frames run on: backend='cpu', 'cuda' or 'auto'. Where a GPU is there, what needs none to be is skipped."""

import pytest
from conftest import same

import handhold

DEVICE = handhold.cuda_device()
without_gpu = pytest.mark.skipif(DEVICE.available, reason=f"there is a GPU here: {DEVICE.name}")


def test_the_device_is_named_or_says_why_there_is_none():
    assert isinstance(DEVICE, handhold.CudaDevice)
    assert DEVICE.available is (DEVICE.reason == "") is (DEVICE.name != "")
    assert "\n" not in DEVICE.name + DEVICE.reason


def test_the_cpu_is_the_default():
    localizer = handhold.Localizer()
    assert (localizer.backend, localizer.backend_reason) == ("cpu", "")
    assert localizer.options["backend"] == "cpu"


@without_gpu
def test_cuda_is_refused_with_the_reason(rod, tmp_path):
    expected = f"backend = cuda: {DEVICE.reason}; use 'cpu', or 'auto' to fall back"
    path = tmp_path / "gpu.toml"
    path.write_text('backend = "cuda"\n')
    for make in (
        lambda: handhold.Localizer(backend="cuda"),
        lambda: handhold.localize(rod, backend="cuda"),
        lambda: handhold.localize(rod, config=path),
    ):
        with pytest.raises(ValueError) as error:
            make()
        assert str(error.value) == expected
    # Options alone ask for no device.
    assert handhold.options(backend="cuda")["backend"] == "cuda"
    assert 'backend = "cuda"\n' in handhold.to_toml(backend="cuda")


@without_gpu
def test_auto_is_the_cpu_and_says_why(rod):
    localizer = handhold.Localizer(backend="auto", samples=1000, hand_aperture=0.1)
    assert (localizer.backend, localizer.backend_reason) == ("cpu", DEVICE.reason)
    assert localizer.options["backend"] == "auto"
    result = localizer.localize(rod)
    assert len(result.handles) == 1
    assert same(result, handhold.localize(rod, samples=1000, hand_aperture=0.1))
