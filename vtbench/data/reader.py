"""Dataset on disk -> arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vtbench.data.format import arrow_schema
from vtbench.data.integrity import column_problem, dataset_problems
from vtbench.data.meta import DatasetMeta, Recordings, read_meta
from vtbench.data.png import decode_png

if TYPE_CHECKING:
    import pandas as pd

Verify = Literal["size", "sha256", False]


class Dataset:
    """A finished dataset, read column by column.

    Attributes:
        path: its folder.
        meta: what `dataset.json` holds.
    """

    recordings: Recordings = "presses"

    def __init__(self, path: Path, meta: DatasetMeta) -> None:
        self.path = path
        self.meta = meta

    @classmethod
    def open(cls, path: Path | str, verify: Verify = "size") -> Self:
        """Open the dataset in folder `path`.

        Args:
            path: folder that holds `dataset.json`.
            verify: compare the shards' sizes with `dataset.json` (`"size"`), their checksums too
                (`"sha256"`), or nothing (`False`).

        Raises:
            ValueError: no dataset there, one of other recordings, or a shard that is missing, truncated or
                changed; it is named.
        """
        path = Path(path)
        dataset = cls(path, read_meta(path))
        if dataset.meta.recordings != cls.recordings:
            raise ValueError(f"{path}: expected a dataset of {cls.recordings}, it holds {dataset.meta.recordings}")
        if verify:
            problems = dataset_problems(path, dataset.meta, checksums=verify == "sha256")
            if problems:
                more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
                raise ValueError(f"{path}: {problems[0]}{more}; generate or import the dataset again")
        return dataset

    @property
    def hash(self) -> str:
        """SHA-256 that changes when any byte of any shard does."""
        return self.meta.hash

    @property
    def classes(self) -> list[str]:
        """Object names; a sample's `label` is an index into them."""
        return list(self.meta.classes)

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.meta.samples

    def __len__(self) -> int:
        return self.n

    def __repr__(self) -> str:
        height, width = self.meta.image_size
        return (
            f"Dataset({str(self.path)!r}: {self.n} samples of {self.meta.name}, {len(self.classes)} objects, "
            f"{self.meta.n_taxels} taxels, {height}x{width} frames)"
        )

    def summary(self) -> dict[str, Any]:
        """Counts that say what the dataset is: samples, objects, presses, units, sessions, taxels, frame size."""
        frame = self.columns(["press", "unit", "session"])
        return {
            "name": self.meta.name,
            "kind": self.meta.kind,
            "samples": self.n,
            "objects": len(self.classes),
            "presses": {str(press): int(count) for press, count in frame["press"].value_counts().items()},
            "units": int(frame["unit"].nunique()),
            "sessions": len(frame[["unit", "session"]].drop_duplicates()),
            "taxels": self.meta.n_taxels,
            "image_size": list(self.meta.image_size),
            "hash": self.hash,
        }

    def columns(self, names: Sequence[str] | None = None) -> pd.DataFrame:
        """Columns as a pandas frame, one row a sample; without `names` all that hold one plain value."""
        if names is None:
            names = [field.name for field in self._schema if not pa.types.is_nested(field.type)]
        frame: pd.DataFrame = self._table(names).to_pandas()
        return frame

    def images(self, indices: Sequence[int] | NDArray[Any] | None = None, column: str = "image") -> NDArray[np.uint8]:
        """Frames (n, height, width, 3) uint8 RGB of the samples `indices` (all by default), in that order."""
        wanted = self._indices(indices)
        frames = np.empty((len(wanted), *self.meta.image_size, 3), np.uint8)
        for places, cells in self._by_shard(wanted, column):
            for place, cell in zip(places, cells.field("bytes"), strict=True):
                frame = decode_png(cell.as_py())
                if frame.shape != frames.shape[1:]:
                    raise ValueError(
                        f"{self.path}: sample {wanted[place]}, column {column!r}: "
                        f"frame of shape {frame.shape}, expected {frames.shape[1:]}"
                    )
                frames[place] = frame
        return frames

    def force(self, indices: Sequence[int] | NDArray[Any] | None = None, column: str = "force") -> NDArray[np.float32]:
        """Taxel forces (n, taxels) float32 newtons: read-back (`force`) or true load (`taxel_load`)."""
        force = self._fixed(indices, column, (self.meta.n_taxels,), np.float32)
        bad = np.argwhere(~np.isfinite(force))
        if bad.size:
            sample = self._indices(indices)[bad[0, 0]]
            raise ValueError(
                f"{self.path}: sample {sample}, column {column!r}: not finite at taxel {bad[0, 1]}; "
                "`vtbench validate` lists every problem"
            )
        return force

    def force_series(self, indices: Sequence[int] | NDArray[Any] | None = None) -> list[NDArray[np.float32]]:
        """Force histories, each (T, taxels) float32 newtons at `meta.rate_hz`."""
        wanted = self._indices(indices)
        series: list[NDArray[np.float32]] = [np.empty((0, self.meta.n_taxels), np.float32)] * len(wanted)
        for places, cells in self._by_shard(wanted, "force_series"):
            values = cells.flatten().flatten().to_numpy().reshape(-1, self.meta.n_taxels)
            stops = np.cumsum(cells.value_lengths().to_numpy())
            for place, part in zip(places, np.split(values, stops[:-1]), strict=True):
                series[place] = part
        return series

    def truth(
        self, field: str, indices: Sequence[int] | NDArray[Any] | None = None
    ) -> NDArray[np.float32] | NDArray[np.bool_]:
        """Ground-truth grids (n, rows, columns): `displacement` [m], `pressure` [Pa] or `contact` (bool)."""
        if field not in self.meta.truth:
            raise ValueError(
                f"{self.path}: no ground truth {field!r}; stored: {', '.join(self.meta.truth) or 'none'} "
                f"(`vtbench generate ... --truth {field}` stores it)"
            )
        kind: Any = np.bool_ if field == "contact" else np.float32
        grids: NDArray[np.float32] | NDArray[np.bool_] = self._fixed(
            indices, f"truth_{field}", self.meta.truth[field], kind
        )
        return grids

    @cached_property
    def _schema(self) -> pa.Schema:
        return arrow_schema(self.meta.columns, self.meta.n_taxels, self.meta.truth, self.meta.classes)

    def _table(self, names: Sequence[str]) -> pa.Table:
        for name in names:
            self._need(name)
        return pa.concat_tables(self._read(shard.name, list(names)) for shard in self.meta.shards)

    def _need(self, column: str) -> None:
        if column not in self.meta.columns:
            raise ValueError(f"{self.path}: no column {column!r}; there are {', '.join(self.meta.columns)}")

    def _read(self, shard: str, names: list[str]) -> pa.Table:
        path = self.path / shard
        try:
            with pq.ParquetFile(path) as file:
                for name in names:
                    problem = column_problem(file.schema_arrow, self._schema.field(name), shard)
                    if problem is not None:
                        raise ValueError(f"{self.path}: {problem}; `vtbench validate` lists every problem")
                return file.read(columns=names, use_threads=False)
        except (pa.ArrowException, OSError) as error:
            reason = " ".join(str(error).split())
            raise ValueError(f"{path}: not readable ({reason}); generate or import it again") from error

    def _indices(self, indices: Sequence[int] | NDArray[Any] | None) -> NDArray[np.int64]:
        wanted = np.arange(self.n) if indices is None else np.asarray(indices, np.int64)
        if wanted.size and not (wanted.min() >= 0 and wanted.max() < self.n):
            raise ValueError(f"{self.path}: sample indices must lie in 0..{self.n - 1}")
        return wanted

    def _by_shard(self, wanted: NDArray[np.int64], column: str) -> Iterator[tuple[NDArray[np.int64], pa.Array]]:
        """For each shard that is needed: places in the result, and the cells that belong there."""
        self._need(column)
        number = wanted // self.meta.samples_per_shard
        for shard in np.unique(number):
            places = np.flatnonzero(number == shard)
            cells = self._read(self.meta.shards[shard].name, [column]).column(0).combine_chunks()
            rows = wanted[places] - shard * self.meta.samples_per_shard
            yield places, cells.take(pa.array(rows))

    def _fixed(
        self,
        indices: Sequence[int] | NDArray[Any] | None,
        column: str,
        shape: tuple[int, ...],
        kind: type[np.generic],
    ) -> NDArray[Any]:
        wanted = self._indices(indices)
        result = np.empty((len(wanted), *shape), kind)
        for places, cells in self._by_shard(wanted, column):
            while pa.types.is_fixed_size_list(cells.type):
                cells = cells.flatten()
            result[places] = cells.to_numpy(zero_copy_only=False).reshape(-1, *shape)
        return result
