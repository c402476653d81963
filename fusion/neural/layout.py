"""Which columns of a feature matrix belong to which modality, and what shape they have there."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from fusion.modality import modality_columns
from fusion.settings import check_known

FloatArray = NDArray[np.float64]
WHOLE = "all"
Kind = Literal["vector", "series", "image"]
_KINDS: dict[int, Kind] = {1: "vector", 2: "series", 3: "image"}


@dataclass(frozen=True)
class Part:
    """One modality: its columns of X, in order, and the shape that they fold into.

    shape is (columns,) of a vector, (steps, channels) of a series, (channels, rows, columns) of an image.
    """

    name: str
    columns: tuple[int, ...]
    shape: tuple[int, ...]

    @property
    def kind(self) -> Kind:
        """What the shape says that it is."""
        return _KINDS[len(self.shape)]

    def of(self, data: FloatArray) -> FloatArray:
        """This modality of rows (n, all columns): (n, *shape)."""
        first, last = self.columns[0], self.columns[-1]
        run = last - first + 1 == len(self.columns) and self.columns == tuple(range(first, last + 1))
        part = data[:, first : last + 1] if run else data[:, list(self.columns)]
        return part.reshape(len(data), *self.shape)


@dataclass(frozen=True)
class Layout:
    """The modalities of a net, in order."""

    parts: tuple[Part, ...]

    @classmethod
    def of(cls, modalities: Mapping[str, Any] | None, shapes: Mapping[str, Any] | None, n_features: int) -> Self:
        """Check and resolve what an estimator was given for matrices of `n_features` columns.

        Raises:
            ValueError: columns that are not there, a shape of an unknown modality, or one that the columns do not fill.
        """
        given = {WHOLE: slice(0, n_features)} if modalities is None else modalities
        columns = modality_columns(given, n_features)
        if shapes is not None and not isinstance(shapes, Mapping):
            raise ValueError(f"shapes must map names of modalities to shapes, got {shapes!r}.")
        check_known("shapes name", shapes or {}, columns)
        parts = []
        for name, chosen in columns.items():
            numbers = np.arange(n_features)[chosen].tolist()
            parts.append(Part(name, tuple(numbers), _resolved(name, (shapes or {}).get(name), len(numbers))))
        return cls(tuple(parts))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the modalities."""
        return tuple(part.name for part in self.parts)

    def present(self, missing: Collection[str]) -> NDArray[np.bool_]:
        """(modalities,) whether each is there when those `missing` are not; ValueError for an unknown name or none."""
        if isinstance(missing, str):
            raise ValueError(f"missing must be a collection of names, such as ({missing!r},), got a text.")
        check_known("missing names", missing, self.names)
        there = np.array([name not in missing for name in self.names])
        if not there.any():
            raise ValueError("missing names every modality: at least one must be there.")
        return there


def _resolved(name: str, shape: Any, n_columns: int) -> tuple[int, ...]:
    """The shape with its -1, of which there may be one, worked out."""
    if shape is None:
        return (n_columns,)
    sizes = [int(size) for size in shape]
    if sizes.count(-1) == 1 and (known := prod(size for size in sizes if size != -1)) > 0:
        sizes[sizes.index(-1)] = n_columns // known
    if len(sizes) not in _KINDS or min(sizes) < 1 or prod(sizes) != n_columns:
        raise ValueError(
            f"shapes[{name!r}]: {tuple(shape)} does not fold {n_columns} columns; expected (columns,), "
            "(steps, channels) or (channels, rows, columns)."
        )
    return tuple(sizes)
