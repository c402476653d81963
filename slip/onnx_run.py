"""Exported slip graphs, run by ONNX Runtime on one thread: a stream as a detector, a batch of sequences at once."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slip.samples import Floats
from slip.training_trial import checked_frames

METADATA_KEY = "slip"


class _Graph:
    def __init__(self, model: str | Path | bytes, needed: str, kind: str) -> None:
        where = "the model" if isinstance(model, bytes) else str(model)
        self._session = load_session(model if isinstance(model, bytes) else Path(model).read_bytes(), where)
        self._inputs: dict[str, Any] = {each.name: each for each in self._session.get_inputs()}
        self._outputs = [each.name for each in self._session.get_outputs()]
        if needed not in self._inputs or "slip_score" not in self._outputs:
            found = ", ".join(name for name in self._inputs if not name.startswith("state_"))
            raise ValueError(f"{where} is no {kind} graph of a slip detector: expected an input {needed}, got {found}")
        self.taxels = int(self._inputs[needed].shape[-1])
        self.uses_frames = bool({"frame", "frames"} & set(self._inputs))

    @property
    def metadata(self) -> dict[str, Any]:
        """What the exporter wrote down: the detector and its parameters, and the parity it measured; else empty."""
        text = self._session.get_modelmeta().custom_metadata_map.get(METADATA_KEY, "{}")
        found: dict[str, Any] = json.loads(text)
        return found


def load_session(model: bytes, where: str = "the model") -> Any:
    """ONNX Runtime on one thread of the CPU. Raises ValueError, naming `where`, for what it cannot load."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f"{where} is no graph that ONNX Runtime can load: {reason}") from None


class OnnxStream(_Graph):
    """A stream graph as a detector: a sample at a time with the states kept here, or a whole sequence.

    Unlike `slip.Detector`s it takes a reading that is not finite: its score is NaN, and so are the ones after it
    for as long as the graph's window holds it. Raises ValueError for a file that is no stream graph.
    """

    def __init__(self, model: str | Path | bytes) -> None:
        super().__init__(model, "force", "stream")
        kinds = {"tensor(double)": np.float64, "tensor(float)": np.float32, "tensor(int64)": np.int64}
        self._fresh = {
            name: np.zeros(each.shape, dtype=kinds[each.type])
            for name, each in self._inputs.items()
            if name.startswith("state_")
        }
        self._passed_on = [name.removesuffix("_out") for name in self._outputs]
        if self.uses_frames:
            self._no_frame = np.zeros((0, *self._inputs["frame"].shape[1:]), dtype=np.uint8)
        self.reset()

    def reset(self) -> None:
        """Forget every sample."""
        self._states = dict(self._fresh)

    def update(self, sample: ArrayLike, *, frame: ArrayLike | None = None) -> float:
        """Take one sample (taxels,) in newtons and the frame (H, W, 3) that came with it; return the score."""
        force = np.asarray(sample, dtype=np.float32)
        if force.shape != (self.taxels,):
            raise ValueError(f"expected a sample of shape ({self.taxels},), got {force.shape}")
        self._states["force"] = force[None]
        if self.uses_frames:
            self._states["frame"] = self._no_frame if frame is None else self._image(frame)
        results = self._session.run(self._outputs, self._states)
        self._states = dict(zip(self._passed_on, results, strict=True))
        return float(self._states.pop("slip_score")[0, 0])

    def score(
        self, sequence: ArrayLike, *, frames: ArrayLike | None = None, frame_samples: ArrayLike | None = None
    ) -> Floats:
        """Score each sample of (T, taxels) newtons as a fresh stream would; (T,). Leaves the stream alone."""
        force = np.asarray(sequence, dtype=np.float32)
        if force.ndim != 2:
            raise ValueError(f"expected forces of shape (T, {self.taxels}), got {force.shape}")
        images: dict[int, Any] = {}
        if frames is not None:
            film, at = checked_frames(frames, frame_samples)
            images = dict(zip(at.tolist(), film, strict=True))
        before = self._states
        self.reset()
        try:
            return np.array([self.update(sample, frame=images.get(t)) for t, sample in enumerate(force)])
        finally:
            self._states = before

    def _image(self, frame: ArrayLike) -> NDArray[np.uint8]:
        image = np.asarray(frame)
        if image.dtype != np.uint8 or image.shape != self._no_frame.shape[1:]:
            raise ValueError(
                f"expected a frame uint8 of shape {self._no_frame.shape[1:]}, got {image.dtype} of {image.shape}"
            )
        return image[None]


class OnnxBatch(_Graph):
    """A batch graph: scores of whole sequences. Raises ValueError for a file that is no batch graph."""

    def __init__(self, model: str | Path | bytes) -> None:
        super().__init__(model, "force_series", "batch")

    def score(
        self, sequences: ArrayLike, *, frames: ArrayLike | None = None, frame_samples: ArrayLike | None = None
    ) -> Floats:
        """Score sequences (N, T, taxels) -> (N, T), or one (T, taxels) -> (T,); NaN where a reading is missing.

        frames : (N, F, H, W, 3) uint8, frame_samples : (N, F), without N for one; none without a camera.
        """
        force = np.asarray(sequences, dtype=np.float32)
        single = force.ndim == 2
        force = force[None] if single else force
        if force.ndim != 3 or force.shape[2] != self.taxels:
            raise ValueError(f"expected forces of shape (N, T, {self.taxels}) or without N, got {force.shape}")
        feed: dict[str, Any] = {"force_series": force}
        if self.uses_frames:
            feed |= self._film(frames, frame_samples, single, len(force))
        scores = self._session.run(["slip_score"], feed)[0].astype(np.float64)
        return scores[0] if single else scores

    def _film(
        self, frames: ArrayLike | None, frame_samples: ArrayLike | None, single: bool, count: int
    ) -> dict[str, Any]:
        size = tuple(self._inputs["frames"].shape[2:])
        film = np.zeros((count, 0, *size), dtype=np.uint8) if frames is None else np.asarray(frames)
        at = np.zeros((count, 0)) if frames is None else np.asarray(frame_samples)
        if single and frames is not None:
            film, at = film[None], at[None]
        if film.dtype != np.uint8 or film.shape[2:] != size or at.shape != film.shape[:2] or len(film) != count:
            raise ValueError(f"expected frames uint8 (N, F, {size}) and frame_samples (N, F), got {film.shape}")
        return {"frames": film, "frame_samples": at.astype(np.int64)}
