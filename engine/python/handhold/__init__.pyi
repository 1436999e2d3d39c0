# What handhold offers, for type checkers and editors. A test compares it with the module, name by name.
import os
from collections.abc import Iterator, Sequence
from typing import Any, Literal, NamedTuple, TypedDict, overload

import numpy as np
import numpy.typing as npt

__version__: str
STEPS: tuple[str, ...]

_Floats = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.uint32]
_Vector = Sequence[float] | _Floats
_Path = str | bytes | os.PathLike[str]
_Method = Literal["default", "paper"]
_Strategy = Literal["uniform", "sum", "max"]
_Axis = Literal["taubin", "normals", "pca"]
_Index = Literal["embree", "grid"]
_Backend = Literal["cpu", "cuda", "auto"]

class _Funnel(TypedDict):
    samples: int
    too_few_points: int
    flat: int
    curvature_low: int
    concave: int
    circle_wide: int
    circle_narrow: int
    poor_fit: int
    no_gap: int
    shell_empty: int
    affordances: int
    cut: int
    not_aligned: int
    unconfirmed: int
    too_short: int
    low_confidence: int
    in_handles: int

class _Times(TypedDict):
    index: float
    samples: float
    neighbours: float
    moments: float
    fit: float
    shell: float
    visibility: float
    handles: float
    total: float

class Handle:
    def __init__(
        self,
        center: _Vector,
        axis: _Vector,
        approach: _Vector,
        radius: float,
        length: float,
        confidence: float = 1.0,
        path: Sequence[_Vector] | _Floats = (),
    ) -> None: ...
    @property
    def center(self) -> _Floats: ...
    @property
    def axis(self) -> _Floats: ...
    @property
    def approach(self) -> _Floats: ...
    @property
    def radius(self) -> float: ...
    @property
    def length(self) -> float: ...
    @property
    def confidence(self) -> float: ...
    @property
    def arc(self) -> float: ...
    @property
    def residual(self) -> float: ...
    @property
    def observed_free(self) -> float: ...
    @property
    def normal_error(self) -> float: ...
    @property
    def path(self) -> _Floats: ...
    @property
    def affordances(self) -> _Indices: ...
    def to_dict(self) -> dict[str, Any]: ...

class Affordance:
    @property
    def center(self) -> _Floats: ...
    @property
    def axis(self) -> _Floats: ...
    @property
    def normal(self) -> _Floats: ...
    @property
    def radius(self) -> float: ...
    @property
    def shell_radius(self) -> float: ...
    @property
    def gap(self) -> float: ...
    @property
    def curvature(self) -> float: ...
    @property
    def observed_free(self) -> float: ...
    @property
    def quality(self) -> float: ...
    @property
    def neighbourhood(self) -> float: ...
    @property
    def sample(self) -> int: ...
    def to_dict(self) -> dict[str, Any]: ...

class Handles:
    @property
    def center(self) -> _Floats: ...
    @property
    def axis(self) -> _Floats: ...
    @property
    def approach(self) -> _Floats: ...
    @property
    def radius(self) -> _Floats: ...
    @property
    def length(self) -> _Floats: ...
    @property
    def confidence(self) -> _Floats: ...
    @property
    def arc(self) -> _Floats: ...
    @property
    def residual(self) -> _Floats: ...
    @property
    def observed_free(self) -> _Floats: ...
    @property
    def normal_error(self) -> _Floats: ...
    @property
    def path(self) -> tuple[_Floats, ...]: ...
    @property
    def affordances(self) -> tuple[_Indices, ...]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Handle]: ...
    @overload
    def __getitem__(self, index: int) -> Handle: ...
    @overload
    def __getitem__(self, index: slice) -> list[Handle]: ...

class Affordances:
    @property
    def center(self) -> _Floats: ...
    @property
    def axis(self) -> _Floats: ...
    @property
    def normal(self) -> _Floats: ...
    @property
    def radius(self) -> _Floats: ...
    @property
    def shell_radius(self) -> _Floats: ...
    @property
    def gap(self) -> _Floats: ...
    @property
    def curvature(self) -> _Floats: ...
    @property
    def observed_free(self) -> _Floats: ...
    @property
    def quality(self) -> _Floats: ...
    @property
    def neighbourhood(self) -> _Floats: ...
    @property
    def sample(self) -> _Indices: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Affordance]: ...
    @overload
    def __getitem__(self, index: int) -> Affordance: ...
    @overload
    def __getitem__(self, index: slice) -> list[Affordance]: ...

class Result:
    @property
    def status(
        self,
    ) -> Literal[
        "ok", "empty", "no_finite_points", "too_few_points", "suspicious_units", "deadline", "cancelled"
    ]: ...
    @property
    def cut(self) -> bool: ...
    @property
    def points(self) -> int: ...
    @property
    def finite_points(self) -> int: ...
    @property
    def handles(self) -> Handles: ...
    @property
    def affordances(self) -> Affordances: ...
    @property
    def funnel(self) -> _Funnel: ...
    @property
    def times_ms(self) -> _Times: ...
    def to_dict(self) -> dict[str, Any]: ...

class Localizer:
    def __init__(
        self,
        *,
        hand: Literal["baxter"] | None = None,
        config: _Path | None = None,
        method: _Method = "default",
        samples: int = 5000,
        strategy: _Strategy = "max",
        seed: int = 1,
        proposal_sigma: float | None = None,
        workspace: Sequence[float] | _Floats | None = None,
        radius: float | Sequence[float] | _Floats | None = None,
        min_neighbours: int = 10,
        axis: _Axis = "taubin",
        index: _Index = "embree",
        hand_aperture: float = 0.08,
        hand_minimum: float = 0.0,
        finger_thickness: float = 0.01,
        finger_width: float = 0.02,
        finger_depth: float = 0.04,
        min_free: float = 0.5,
        reach: float | None = None,
        shell_gap_area_mm2: float = 12.0,
        shell_inner_area_mm2: float = 100.0,
        align_angle: float = 0.35,
        align_offset: float = 0.01,
        align_radius: float = 0.005,
        handle_gap: float = 0.015,
        handle_min_affordances: int = 3,
        handle_min_length: float = 0.02,
        min_confidence: float | None = None,
        deadline_ms: float | None = None,
        backend: _Backend = "cpu",
        threads: int = 0,
    ) -> None: ...
    def localize(
        self,
        points: npt.ArrayLike,
        *,
        viewpoint: _Vector | None = (0.0, 0.0, 0.0),
        guesses: npt.ArrayLike | None = None,
    ) -> Result: ...
    def set_seed(self, seed: int) -> None: ...
    def cancel(self) -> None: ...
    def samples(self) -> tuple[_Floats, npt.NDArray[np.uint8]]: ...
    @property
    def options(self) -> dict[str, Any]: ...
    @property
    def backend(self) -> Literal["cpu", "cuda"]: ...
    @property
    def backend_reason(self) -> str: ...

def localize(
    points: npt.ArrayLike,
    *,
    viewpoint: _Vector | None = (0.0, 0.0, 0.0),
    hand: Literal["baxter"] | None = None,
    config: _Path | None = None,
    method: _Method = "default",
    samples: int = 5000,
    strategy: _Strategy = "max",
    seed: int = 1,
    proposal_sigma: float | None = None,
    workspace: Sequence[float] | _Floats | None = None,
    radius: float | Sequence[float] | _Floats | None = None,
    min_neighbours: int = 10,
    axis: _Axis = "taubin",
    index: _Index = "embree",
    hand_aperture: float = 0.08,
    hand_minimum: float = 0.0,
    finger_thickness: float = 0.01,
    finger_width: float = 0.02,
    finger_depth: float = 0.04,
    min_free: float = 0.5,
    reach: float | None = None,
    shell_gap_area_mm2: float = 12.0,
    shell_inner_area_mm2: float = 100.0,
    align_angle: float = 0.35,
    align_offset: float = 0.01,
    align_radius: float = 0.005,
    handle_gap: float = 0.015,
    handle_min_affordances: int = 3,
    handle_min_length: float = 0.02,
    min_confidence: float | None = None,
    deadline_ms: float | None = None,
    backend: _Backend = "cpu",
    threads: int = 0,
) -> Result: ...
def options(
    *,
    hand: Literal["baxter"] | None = None,
    config: _Path | None = None,
    method: _Method = "default",
    samples: int = 5000,
    strategy: _Strategy = "max",
    seed: int = 1,
    proposal_sigma: float | None = None,
    workspace: Sequence[float] | _Floats | None = None,
    radius: float | Sequence[float] | _Floats | None = None,
    min_neighbours: int = 10,
    axis: _Axis = "taubin",
    index: _Index = "embree",
    hand_aperture: float = 0.08,
    hand_minimum: float = 0.0,
    finger_thickness: float = 0.01,
    finger_width: float = 0.02,
    finger_depth: float = 0.04,
    min_free: float = 0.5,
    reach: float | None = None,
    shell_gap_area_mm2: float = 12.0,
    shell_inner_area_mm2: float = 100.0,
    align_angle: float = 0.35,
    align_offset: float = 0.01,
    align_radius: float = 0.005,
    handle_gap: float = 0.015,
    handle_min_affordances: int = 3,
    handle_min_length: float = 0.02,
    min_confidence: float | None = None,
    deadline_ms: float | None = None,
    backend: _Backend = "cpu",
    threads: int = 0,
) -> dict[str, Any]: ...
def to_toml(
    *,
    hand: Literal["baxter"] | None = None,
    config: _Path | None = None,
    method: _Method = "default",
    samples: int = 5000,
    strategy: _Strategy = "max",
    seed: int = 1,
    proposal_sigma: float | None = None,
    workspace: Sequence[float] | _Floats | None = None,
    radius: float | Sequence[float] | _Floats | None = None,
    min_neighbours: int = 10,
    axis: _Axis = "taubin",
    index: _Index = "embree",
    hand_aperture: float = 0.08,
    hand_minimum: float = 0.0,
    finger_thickness: float = 0.01,
    finger_width: float = 0.02,
    finger_depth: float = 0.04,
    min_free: float = 0.5,
    reach: float | None = None,
    shell_gap_area_mm2: float = 12.0,
    shell_inner_area_mm2: float = 100.0,
    align_angle: float = 0.35,
    align_offset: float = 0.01,
    align_radius: float = 0.005,
    handle_gap: float = 0.015,
    handle_min_affordances: int = 3,
    handle_min_length: float = 0.02,
    min_confidence: float | None = None,
    deadline_ms: float | None = None,
    backend: _Backend = "cpu",
    threads: int = 0,
) -> str: ...
def cuda_device() -> CudaDevice: ...
def isa() -> Literal["scalar", "avx2", "avx512", "neon"]: ...

class CudaDevice:
    @property
    def available(self) -> bool: ...
    @property
    def name(self) -> str: ...
    @property
    def reason(self) -> str: ...

class Cloud(NamedTuple):
    points: npt.NDArray[np.float32]
    rgb: npt.NDArray[np.uint8] | None
    viewpoint: tuple[float, float, float] | None

def read_cloud(path: _Path) -> Cloud: ...

class Track:
    @property
    def id(self) -> int: ...
    @property
    def handle(self) -> Handle: ...
    @property
    def velocity(self) -> _Floats: ...
    @property
    def age(self) -> int: ...
    @property
    def unseen(self) -> int: ...

class Tracker:
    def __init__(
        self,
        *,
        max_offset: float = 0.04,
        max_angle: float = 0.6,
        max_radius: float = 0.4,
        weight: float = 0.4,
        keep: int = 15,
    ) -> None: ...
    def update(
        self, handles: Handles | Sequence[Handle], *, T_now_last: npt.ArrayLike | None = None
    ) -> list[Track]: ...
    @property
    def tracks(self) -> list[Track]: ...
    def guesses(self, *, T_next_now: npt.ArrayLike | None = None) -> _Floats: ...
