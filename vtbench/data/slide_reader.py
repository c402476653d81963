"""Dataset of slides on disk -> arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtbench.data.meta import Recordings
from vtbench.data.png import decode_png
from vtbench.data.reader import Dataset


class SlideDataset(Dataset):
    """A finished dataset of slides: forces in time, the state of the contact at each sample, the onset of slip."""

    recordings: Recordings = "slides"

    def __repr__(self) -> str:
        objects = ", ".join(self.classes)
        return f"SlideDataset({str(self.path)!r}: {self.n} trials of {self.meta.name}, {objects})"

    def summary(self) -> dict[str, Any]:
        """Counts that say what the dataset is: trials by kind, objects, minutes, taxels."""
        frame = self.columns(["kind", "unit", "onset"])
        minutes = sum(len(state) for state in self.states()) / (self.meta.rate_hz or 1.0) / 60.0
        return {
            "name": self.meta.name,
            "kind": self.meta.kind,
            "samples": self.n,
            "objects": len(self.classes),
            "kinds": {str(kind): int(count) for kind, count in frame["kind"].value_counts(sort=False).items()},
            "with_slip": int(frame["onset"].notna().sum()),
            "units": int(frame["unit"].nunique()),
            "minutes": round(minutes, 3),
            "rate_hz": self.meta.rate_hz,
            "taxels": self.meta.n_taxels,
            "image_size": list(self.meta.image_size),
            "hash": self.hash,
        }

    def states(self, indices: Sequence[int] | NDArray[Any] | None = None) -> list[NDArray[np.uint8]]:
        """State of each sample, each (T,): 0 stick, 1 partial slip, 2 gross slip."""
        wanted = self._indices(indices)
        states: list[NDArray[np.uint8]] = [np.empty(0, np.uint8)] * len(wanted)
        for places, cells in self._by_shard(wanted, "state"):
            for place, cell in zip(places, cells, strict=True):
                states[place] = cell.values.to_numpy(zero_copy_only=False)
        return states

    def onsets(self) -> list[int | None]:
        """First sample of gross slip of each trial; None without."""
        return [None if onset != onset else int(onset) for onset in self.columns(["onset"])["onset"]]

    def each_series(self, indices: Sequence[int] | NDArray[Any]) -> Iterator[NDArray[np.float32]]:
        """Forces (T, taxels) of the trials `indices`, in that order, one shard in memory at a time."""
        wanted = self._indices(indices)
        shards = wanted // self.meta.samples_per_shard
        starts = np.flatnonzero(np.diff(shards, prepend=-1))
        for part in np.split(wanted, starts[1:]):
            yield from self.force_series(part)

    def frames(self, index: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        """Frames (F, height, width, 3) of one trial and their times (F,) in seconds on the clock of the forces.

        Raises:
            ValueError: the dataset was written without frames.
        """
        ((_, cells),) = self._by_shard(self._indices([index]), "frames")
        ((_, times),) = self._by_shard(self._indices([index]), "frame_time_s")
        pictures = [decode_png(frame["bytes"]) for frame in cells[0].as_py()]
        size = (0, *self.meta.image_size, 3)
        return np.stack(pictures) if pictures else np.empty(size, np.uint8), np.array(times[0].as_py())
