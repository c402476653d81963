"""What the recordings of a task offer to a model: the contract, and the arrays in any order, written where it reads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtbench.onnx_eval.contract import Contract, Port
from vtbench.tasks.base import TaskData
from vtbench.tasks.slides import SlideData, SlipTask

CHUNK = 256
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Offer:
    """The inputs of a task's samples.

    Attributes:
        contract: names, types and shapes; the classes.
        plain: (rows, from, to) of an input with one row a sample, as an array.
        series: every sample's forces in time, by sample, in any order; None without.
        lengths: (samples,) of those.
    """

    contract: Contract
    plain: dict[str, Callable[[Rows], NDArray[Any]]]
    series: Callable[[Rows], Any] | None = None
    lengths: NDArray[np.int64] | None = None

    def write(self, folder: Path, names: Sequence[str], order: Rows) -> tuple[dict[str, Any], ...]:
        """Write inputs of the samples `order`, in that order, as raw files; returns what a job says of them."""
        told = []
        for port in self.contract.taken(names):
            if port.name == "force_series":
                shape = self._write_series(folder, order)
            else:
                shape = self._write_plain(folder / f"{port.name}.raw", port.name, order)
            told.append({"name": port.name, "dtype": port.dtype, "shape": list(shape)})
        return tuple(told)

    def _write_plain(self, path: Path, name: str, order: Rows) -> tuple[int, ...]:
        shape: tuple[int, ...] = ()
        with path.open("wb") as file:
            for start in range(0, len(order), CHUNK):
                part = self.plain[name](order[start : start + CHUNK])
                shape = part.shape[1:]
                file.write(np.ascontiguousarray(part).tobytes())
        return (len(order), *shape)

    def _write_series(self, folder: Path, order: Rows) -> tuple[int, ...]:
        assert self.series is not None
        assert self.lengths is not None
        starts = np.concatenate([[0], np.cumsum(self.lengths[order])]).astype(np.int64)
        place = {int(sample): at for at, sample in enumerate(order)}
        taxels = int(next(port for port in self.contract.inputs if port.name == "force_series").shape[-1])  # type: ignore[index,arg-type]
        shape = (int(starts[-1]), taxels)
        target = np.memmap(folder / "force_series.raw", np.float32, "w+", shape=shape)
        for sample, values in self.series(order):
            at = place[int(sample)]
            target[starts[at] : starts[at + 1]] = values
        target.flush()
        starts.tofile(folder / "starts.raw")
        return shape


def offer_of(task: Any, paths: Sequence[Path], data: TaskData) -> Offer:
    """What the samples of `data`, loaded from `paths` by `task`, offer."""
    if isinstance(task, SlipTask):
        assert isinstance(data, SlideData)
        return _slides(data)
    scores = Port("scores", "float32", ("N", len(data.classes)))
    if task.reads == "presses":
        return _presses(paths[0], data, scores)
    if task.reads == "fabricslide16":
        from vtbench.data import load_fabricslide16

        series = load_fabricslide16(paths[0]).series
        return _in_time(scores, [np.asarray(series[row], np.float32) for row in data.rows])
    if task.reads == "biotacsp_stability_v2":
        values = data.block("electrodes")
        contract = Contract((Port("force", "float32", ("N", values.shape[1])),), scores)
        return Offer(contract, {"force": lambda order: values[order]})
    raise ValueError(f"{task.id}: models cannot be evaluated on its recordings yet")


def _presses(path: Path, data: TaskData, scores: Port) -> Offer:
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    height, width = dataset.meta.image_size
    frame, taxels = ("N", height, width, 3), dataset.meta.n_taxels
    ports = [Port("image", "uint8", frame)]
    plain: dict[str, Callable[[Rows], NDArray[Any]]] = {"image": lambda order: dataset.images(data.rows[order])}
    if "image_rest" in dataset.meta.columns:
        ports.append(Port("image_rest", "uint8", frame))
        plain["image_rest"] = lambda order: dataset.images(data.rows[order], column="image_rest")
    force = dataset.force()
    ports.append(Port("force", "float32", ("N", taxels)))
    plain["force"] = lambda order: force[data.rows[order]]
    if "force_series" not in dataset.meta.columns:
        return Offer(Contract(tuple(ports), scores), plain)
    in_time = _in_time(scores, [np.asarray(each) for each in dataset.force_series(data.rows)])
    ports += in_time.contract.inputs
    return Offer(Contract(tuple(ports), scores), plain, in_time.series, in_time.lengths)


def _in_time(output: Port, series: Sequence[NDArray[np.float32]]) -> Offer:
    lengths = np.array([len(each) for each in series], np.int64)
    contract = Contract((_series_port(lengths, series[0].shape[1]),), output)
    return Offer(contract, {}, lambda order: ((sample, series[sample]) for sample in order.tolist()), lengths)


def _slides(data: SlideData) -> Offer:
    lengths = np.array([truth.samples for truth in data.truth], np.int64)
    taxels = next(data.each_force([0]))[1].shape[1]
    contract = Contract((_series_port(lengths, taxels),), Port("slip_score", "float32", ("N", "T")))
    return Offer(contract, {}, data.each_force, lengths)


def _series_port(lengths: NDArray[np.int64], taxels: int) -> Port:
    same = len(np.unique(lengths)) == 1
    return Port("force_series", "float32", ("N", int(lengths[0]) if same else "T", taxels))
