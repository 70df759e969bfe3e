"""Hands in the columns of a data set."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from .. import grasps
from .._extricate import Scene
from ._columns import Array, Reasons, column, sifted, table


@dataclasses.dataclass(frozen=True)
class Hands:
    """How the columns of a data set hold hands: poses of the root link, and joints by name. Rows become configurations by
    `grasps.from_arrays`.

    translation: name of a column (n, 3) [m], or names of three columns (n,).
    rotation: name of a column in the form of `rotation_as`, or the names of three or more columns (n,).
    joints: by joint, the name of its column (n,) [rad or m]; or the name of one column (n, k).
    names: names of the joints in the columns of `joints`, if that is one column.
    rotation_as: "matrix" (n, 3, 3), "quat_xyzw" or "quat_wxyz" (n, 4), "rpy" (n, 3) [rad] or "columns" (n, 6).
    base: name of the floating joint; None if the scene has one.
    ignore: joints to leave out, such as those that mimic others.
    """

    translation: Union[str, Sequence[str]] = "translation"
    rotation: Union[str, Sequence[str]] = "rotation"
    joints: Union[str, Mapping[str, str]] = "joints"
    names: Optional[Sequence[str]] = None
    rotation_as: grasps.Rotation = "matrix"
    base: Optional[str] = None
    ignore: Sequence[str] = ()

    def _shape(self, part: str) -> Tuple[int, ...]:
        if part == "translation":
            return (3,)
        return {"matrix": (3, 3), "rpy": (3,), "columns": (6,)}.get(self.rotation_as, (4,))

    def _numbers(self, batch: Mapping[str, Any], part: str, reasons: Reasons) -> Array:
        """Returns the translations or the rotations of all rows; adds the spoiled ones to `reasons`."""
        names = getattr(self, part)
        if isinstance(names, str):
            found, wrong = table(names, column(batch, names), self._shape(part))
            reasons.update(wrong)
            return found
        return np.stack([self._column(batch, name, (), reasons) for name in names], axis=1)

    @staticmethod
    def _column(batch: Mapping[str, Any], name: str, shape: Tuple[int, ...], reasons: Reasons) -> Array:
        found, wrong = table(name, column(batch, name), shape)
        reasons.update(wrong)
        return found

    def configurations(self, scene: Scene, batch: Mapping[str, Any]) -> Tuple[Array, Reasons]:
        """Returns the configurations (n, nq) of the rows, and which rows are spoiled."""
        reasons: Reasons = {}
        translation, rotation = self._numbers(batch, "translation", reasons), self._numbers(batch, "rotation", reasons)
        joints: Dict[str, Array] = {}
        if isinstance(self.joints, str):
            names = list(self.names or ())
            all_joints = self._column(batch, self.joints, (len(names),), reasons)
            joints = {name: all_joints[:, at] for at, name in enumerate(names)}
        else:
            joints = {name: self._column(batch, source, (), reasons) for name, source in self.joints.items()}

        def read(at: Array) -> Array:
            chosen = {name: values[at] for name, values in joints.items()}
            form = {"rotation_as": self.rotation_as, "base": self.base, "ignore": self.ignore}
            return grasps.from_arrays(scene, translation[at], rotation[at], chosen, **form)  # type: ignore[arg-type]

        # A hand that the scene does not know is no fault of a row.
        read(np.zeros(0, dtype=np.int64))
        places = np.array([place for place in range(len(translation)) if place not in reasons], dtype=np.int64)
        good, wrong = sifted(read, places)
        found = np.full((len(translation), scene.nq), np.nan)
        for at, Q in good:
            found[at] = Q
        return found, {**reasons, **wrong}

    def stored(self, scene: Scene, batch: Mapping[str, Any], Q: Array) -> Dict[str, Array]:
        """Returns the columns of `batch` with the hands Q (n, nq) in place of its own; rows of nan keep theirs."""
        places = np.flatnonzero(np.isfinite(Q).all(axis=1))
        names = [*(self.names or ())] if isinstance(self.joints, str) else [*self.joints]
        kept = [name for name in names if name not in self.ignore]
        arrays = grasps.to_arrays(scene, Q[places], names=kept, rotation_as=self.rotation_as, base=self.base)
        found: Dict[str, Array] = {}

        def put(name: str, values: Array) -> None:
            found[name] = table(name, column(batch, name), values.shape[1:])[0].copy()
            found[name][places] = values

        for part, values in (("translation", arrays.translation), ("rotation", arrays.rotation)):
            sources = getattr(self, part)
            if isinstance(sources, str):
                put(sources, values)
            else:
                for at, source in enumerate(sources):
                    put(source, values[:, at])
        if isinstance(self.joints, str):
            merged = table(self.joints, column(batch, self.joints), (len(names),))[0][places]
            merged[:, [names.index(name) for name in kept]] = arrays.joints
            put(self.joints, merged)
        else:
            for at, name in enumerate(kept):
                put(self.joints[name], arrays.joints[:, at])
        return found
