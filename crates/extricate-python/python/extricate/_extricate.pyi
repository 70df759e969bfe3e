"""The native half of extricate."""

from os import PathLike
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Literal, Mapping, Optional, Protocol, Sequence, Tuple, Union, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import TypedDict, Unpack

from ._answer import Answer
from ._motion import Escape, Plan, Repaired
from ._options import Effort, LimitRule, QueryOptions
from ._page import Page
from ._parts import Obstacle, Pose, Robot

_Path = Union[str, PathLike[str]]
_Robot = Union[_Path, Robot]
_NamePair = Tuple[str, str]
_Keep = Union[str, Mapping[str, Any], Sequence[Union[str, Mapping[str, Any]]]]
_Weights = Mapping[str, Union[float, Tuple[float, float]]]
_Floats = npt.NDArray[np.float64]
_Metric = Literal["joint", "object-norm", "max-displacement"]
_ErrorRule = Literal["raise", "mask"]
_Tell = Union[bool, Callable[[Progress], Optional[bool]]]

__all__ = [
    "Joint",
    "Model",
    "Progress",
    "Roadmap",
    "Scene",
    "Solver",
    "Stream",
    "__version__",
    "_find_package",
    "_octree_cells",
    "_pose_matrix",
    "_query_options",
    "import_world",
    "learn",
]

__version__: str

def import_world(
    path: _Path,
    output: _Path,
    *,
    robot: Union[_Path, Scene, None] = None,
    load_limits: Optional[Mapping[str, int]] = None,
) -> List[Path]: ...
def _query_options() -> List[Tuple[str, str, str]]: ...
def _find_package(package: str, near: _Path, packages: Sequence[_Path]) -> Optional[Path]: ...
def _octree_cells(element: str, id: str, is_binary: bool, resolution: float, data: bytes) -> npt.NDArray[np.int32]: ...
def _pose_matrix(pose: Optional[Pose]) -> _Floats: ...

class _JointState(Protocol):
    """The fields of a JointState of ROS."""

    @property
    def name(self) -> Sequence[str]: ...
    @property
    def position(self) -> Sequence[float]: ...

@final
class Joint:
    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def start(self) -> int: ...
    @property
    def stop(self) -> int: ...

@final
class Progress:
    @property
    def stage(self) -> str: ...
    @property
    def fraction(self) -> float: ...
    @property
    def labels(self) -> int: ...
    @property
    def boundary_samples(self) -> int: ...
    @property
    def accuracy(self) -> Optional[float]: ...

class _QueryKeywords(TypedDict, total=False):
    """The keywords of `query`, for calls that pass them on. stubtest refuses them for calls that name theirs."""

    options: Optional[QueryOptions]
    effort: Effort
    exits: int
    gap: Optional[float]
    starts: Optional[int]
    max_checks: Optional[int]
    max_seconds: Optional[float]
    segment: bool
    contacts: bool
    clearance: Optional[float]
    locked: Optional[Sequence[str]]
    free: Optional[Sequence[str]]
    keep: Optional[_Keep]
    touch: Optional[Sequence[_NamePair]]
    weights: Optional[_Weights]
    toward: Optional[npt.ArrayLike]
    toward_share: float
    free_radius: bool
    limits: LimitRule

class _Calls:
    """The calls that a scene, a model and a solver share."""

    def query(
        self,
        q: npt.ArrayLike,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
    ) -> Optional[Answer]: ...
    def signed_distance(
        self,
        Q: npt.ArrayLike,
        *,
        within: Optional[float] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        threads: int = 0,
    ) -> Any: ...
    def free_radius(self, Q: npt.ArrayLike, *, threads: int = 0) -> Any: ...
    def show(
        self, Q: Optional[npt.ArrayLike] = None, *, path: Optional[_Path] = None, open: Optional[bool] = None,
        live: bool = False, **options: Unpack[_QueryKeywords],
    ) -> Page: ...
    def stream(
        self,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        hysteresis: float = 0.0,
        starts_per_frame: int = 2,
        continuous: bool = False,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
    ) -> Stream: ...
    def escape(
        self,
        q: npt.ArrayLike,
        *,
        aim: Optional[float] = None,
        tolerance: float = 1e-3,
        keep: Optional[_Keep] = None,
        toward: Optional[npt.ArrayLike] = None,
        exits: int = 6,
        resolution: float = 1e-4,
        tree_checks: int = 20_000,
        seed: int = 0,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
    ) -> Escape: ...
    def plan(
        self,
        start: npt.ArrayLike,
        goal: npt.ArrayLike,
        *,
        roadmap: Optional[Roadmap] = None,
        resolution: float = 1e-4,
        tolerance: float = 1e-3,
        keep: Optional[_Keep] = None,
        clearance: Optional[float] = None,
        shortcut: bool = True,
        seed: int = 0,
        threads: int = 0,
        max_checks: Optional[int] = 1_000_000,
        max_seconds: Optional[float] = None,
    ) -> Plan: ...
    def repair(
        self,
        path: npt.ArrayLike,
        *,
        aim: Optional[float] = None,
        max_deviation: Optional[float] = None,
        keep: Optional[_Keep] = None,
        frames: bool = False,
        max_step: Optional[float] = None,
        touch: Optional[float] = None,
        resolution: float = 1e-4,
        seed: int = 0,
        max_checks: Optional[int] = 100_000,
        max_seconds: Optional[float] = None,
    ) -> Repaired: ...
    def release(
        self,
        Q: npt.ArrayLike,
        *,
        object: Union[str, Obstacle, Sequence[Obstacle]],
        keep: Literal["contacts", "pose"] = "contacts",
        touch: float = 2e-3,
        friction: Optional[float] = 0.8,
        open: Optional[npt.ArrayLike] = None,
        clearance: Optional[float] = None,
        locked: Sequence[str] = ...,
        weights: Union[_Weights, str, None] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        threads: int = 0,
    ) -> Any: ...  # Optional[Grasp] for one row, else a list of them: types of arrays do not tell which.

@final
class Scene(_Calls):
    def __new__(
        cls,
        robot: Union[_Robot, Sequence[_Robot]],
        obstacles: Iterable[Obstacle] = ...,
        *,
        clearance: Union[float, Mapping[str, float]] = 1e-4,
        metric: _Metric = "joint",
        weights: Optional[_Weights] = None,
        disable: Sequence[Sequence[str]] = ...,
        enable: Sequence[Sequence[str]] = ...,
        padding: Optional[Mapping[str, float]] = None,
        pair_clearance: Sequence[Tuple[str, str, float]] = ...,
        packages: Sequence[_Path] = ...,
    ) -> Scene: ...
    @staticmethod
    def load(
        path: _Path, *, load_limits: Optional[Mapping[str, int]] = None, packages: Sequence[_Path] = ...
    ) -> Scene: ...
    @staticmethod
    def builtin(name: str) -> Scene: ...
    @staticmethod
    def builtin_files(name: str) -> Dict[str, bytes]: ...
    @property
    def nq(self) -> int: ...
    @property
    def nv(self) -> int: ...
    @property
    def clearance(self) -> float: ...
    @property
    def metric(self) -> _Metric: ...
    @property
    def joints(self) -> List[Joint]: ...
    @property
    def lower(self) -> _Floats: ...
    @property
    def upper(self) -> _Floats: ...
    @property
    def bodies(self) -> List[str]: ...
    @property
    def pairs(self) -> List[_NamePair]: ...
    @property
    def warnings(self) -> List[str]: ...
    def moved(self, poses: Mapping[str, Pose]) -> Scene: ...
    def with_obstacles(self, obstacles: Iterable[Obstacle]) -> Scene: ...
    def without(self, names: Sequence[str]) -> Scene: ...
    def disabled(self, pairs: Sequence[Sequence[str]]) -> Scene: ...
    def attach(
        self, shape: Obstacle, *, link: str, pose: Optional[Pose] = None, touch: Sequence[str] = ...
    ) -> Scene: ...
    def in_world(
        self, path: _Path, *, load_limits: Optional[Mapping[str, int]] = None, packages: Sequence[_Path] = ...
    ) -> Scene: ...
    def _in_world_text(self, name: str, text: str) -> Scene: ...
    def _repr_html_(self) -> str: ...
    def config(self, positions: Union[Mapping[str, Any], _JointState]) -> _Floats: ...
    def _config_anywhere(self, positions: Mapping[str, Any]) -> _Floats: ...
    def positions(self, q: npt.ArrayLike) -> Dict[str, Any]: ...
    def poses(self, Q: npt.ArrayLike, of: Optional[Sequence[str]] = None) -> _Floats: ...
    def mesh(self, body: str, segments: int = 32) -> Tuple[_Floats, npt.NDArray[np.int64]]: ...
    def check(self, Q: npt.ArrayLike, *, threads: int = 0) -> npt.NDArray[np.bool_]: ...
    def distances(self, Q: npt.ArrayLike, *, threads: int = 0) -> _Floats: ...
    def pair_distances(self, Q: npt.ArrayLike, *, threads: int = 0) -> _Floats: ...
    def contacts(self, Q: npt.ArrayLike, *, within: float, threads: int = 0) -> npt.NDArray[np.void]: ...
    def distance_jacobians(self, Q: npt.ArrayLike, *, within: float, threads: int = 0) -> npt.NDArray[np.void]: ...
    def check_segments(
        self, A: npt.ArrayLike, B: npt.ArrayLike, *, resolution: float = 1e-4, threads: int = 0
    ) -> npt.NDArray[np.void]: ...
    def robot_filter(
        self, points: npt.ArrayLike, q: npt.ArrayLike, padding: float = 0.0
    ) -> npt.NDArray[np.bool_]: ...
    def colliding_pairs(self, q: npt.ArrayLike) -> List[_NamePair]: ...
    def always_colliding(self, n: int = 100, *, seed: int = 0, share: float = 1.0) -> List[_NamePair]: ...
    def sample(self, n: int, *, seed: int = 0, colliding: Optional[bool] = None, threads: int = 0) -> _Floats: ...
    def query_batch(
        self,
        Q: npt.ArrayLike,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
        errors: _ErrorRule = "raise",
        threads: int = 0,
    ) -> npt.NDArray[np.void]: ...
    @staticmethod
    def _from_bytes(data: bytes) -> Scene: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...

@final
class Roadmap:
    def __new__(cls, scene: Scene, *, seed: int = 0) -> Roadmap: ...
    @staticmethod
    def load(path: _Path, scene: Scene) -> Roadmap: ...
    def save(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...
    @property
    def edges(self) -> int: ...
    @property
    def checks(self) -> int: ...

@final
class Model(_Calls):
    @staticmethod
    def load(path: _Path) -> Model: ...
    def save(self, path: _Path) -> None: ...
    @staticmethod
    def from_bytes(data: bytes) -> Model: ...
    def to_bytes(self) -> bytes: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def boundary(self) -> _Floats: ...
    @property
    def support_vectors(self) -> _Floats: ...
    @property
    def statistics(self) -> Dict[str, Any]: ...
    @overload
    def query(
        self,
        q: npt.ArrayLike,
        *,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: None = None,
        free: None = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
    ) -> Answer: ...
    @overload
    def query(
        self,
        q: npt.ArrayLike,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
    ) -> Optional[Answer]: ...
    def query_batch(
        self,
        Q: npt.ArrayLike,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
        errors: _ErrorRule = "raise",
        threads: int = 0,
    ) -> npt.NDArray[np.void]: ...
    def in_world(self, world: Union[Scene, Iterable[Obstacle]]) -> Solver: ...
    def in_scene(self, scene: Scene) -> Solver: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...

@final
class Solver(_Calls):
    def __new__(
        cls,
        scene: Scene,
        model: Optional[Model] = None,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
    ) -> Solver: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def model(self) -> Optional[Model]: ...
    def with_scene(self, scene: Scene) -> Solver: ...
    def nearest_exit(self, q: npt.ArrayLike) -> Optional[_Floats]: ...
    def check(self, Q: npt.ArrayLike, *, threads: int = 0) -> npt.NDArray[np.bool_]: ...
    def batch(
        self,
        Q: npt.ArrayLike,
        *,
        options: Optional[QueryOptions] = None,
        effort: Effort = "refined",
        exits: int = 1,
        gap: Optional[float] = None,
        starts: Optional[int] = None,
        max_checks: Optional[int] = None,
        max_seconds: Optional[float] = None,
        segment: bool = False,
        contacts: bool = False,
        clearance: Optional[float] = None,
        locked: Optional[Sequence[str]] = None,
        free: Optional[Sequence[str]] = None,
        keep: Optional[_Keep] = None,
        touch: Optional[Sequence[_NamePair]] = None,
        weights: Optional[_Weights] = None,
        toward: Optional[npt.ArrayLike] = None,
        toward_share: float = 0.25,
        free_radius: bool = False,
        limits: LimitRule = "forgive",
        errors: _ErrorRule = "raise",
        threads: int = 0,
    ) -> npt.NDArray[np.void]: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...

@final
class Stream:
    @overload
    def query(self, q: npt.ArrayLike, *, scene: None = None) -> Answer: ...
    @overload
    def query(self, q: npt.ArrayLike, *, scene: Solver) -> Optional[Answer]: ...
    def restart(self) -> None: ...

def learn(
    scene: Scene,
    *,
    labels: Optional[float] = None,
    seconds: Optional[float] = None,
    seed: Optional[int] = None,
    threads: int = 0,
    progress: Optional[_Tell] = None,
) -> Model: ...
