"""Every detector as an ONNX graph: of whole sequences, or of one sample with the states that it carries on.

batch : `force_series` (N, T, taxels) float32 newtons -> `slip_score` (N, T) float32.
stream : `force` (1, taxels) float32 and every `state_*` -> `slip_score` (1, 1) and every `state_*_out`, to be fed back
as `state_*`; states of zeros are a fresh stream.
With a camera a batch also takes `frames` (N, F, H, W, 3) uint8 and `frame_samples` (N, F) int64, a stream `frame`
(0 or 1, H, W, 3) uint8.

Between its ends a graph computes in double precision, as the detectors do. What float32 costs: forces are read to 6e-8
of themselves, and so are scores written; a score beyond 3e38 is infinite. A reading that is not finite makes its score
NaN, and every later one until it has left the detector's window (`settling` samples), never a finite one; it leaves
nothing behind.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from onnx import ModelProto

from slip.covariance import Covariance
from slip.detector import Detector, DifferenceDetector
from slip.energy import Energy
from slip.graph.builder import Graph, add_metadata
from slip.graph.camera import held_embedding
from slip.graph.covariance import covariance_score
from slip.graph.energy import energy_score, spectral_score
from slip.graph.net import net_score
from slip.graph.parity import Parity, check_force, compare
from slip.graph.readings import differences, force_input, score_output
from slip.neural import NeuralForce, NeuralForceFrames
from slip.onnx_run import METADATA_KEY, OnnxBatch, OnnxStream
from slip.samples import as_sequence
from slip.spectral import Spectral
from slip.training_trial import checked_frames

Kind = Literal["batch", "stream"]
EXPORTED = (Covariance, Energy, Spectral, NeuralForce, NeuralForceFrames)


def export_onnx(
    detector: Detector,
    path: str | Path,
    kind: Kind = "batch",
    n_taxels: int = 16,
    check: ArrayLike | None = None,
    *,
    frames: ArrayLike | None = None,
    frame_samples: ArrayLike | None = None,
) -> Parity:
    """Write the graph of a detector and return how far its scores are from the detector's own.

    check : forces (T, taxels) in newtons, rounded to float32, that both score; by default rest, a rising load and a
        burst. frames, frame_samples : as `NeuralForceFrames.score` takes them; a net with a camera needs them, and
        is exported for their height and width.

    The report stands in the file's metadata under "slip" too, beside the detector's parameters. Raises ValueError,
    and writes nothing, for a detector that has no graph of its own or skips missing samples, for a time-side window
    above 1024, and where the scores differ by more than float32 explains.
    """
    found = _exportable(detector, kind, n_taxels)
    size: tuple[int, int] | None = None
    film: dict[str, Any] = {}
    if isinstance(found, NeuralForceFrames):
        if frames is None:
            raise ValueError("expected frames and frame_samples to check a net with a camera on, got none")
        images, at = checked_frames(frames, frame_samples)
        film, size = {"frames": images, "frame_samples": at}, (images.shape[1], images.shape[2])
    model = build_model(found, kind, n_taxels, size)
    values = check_force(found.settling, n_taxels) if check is None else as_sequence(check)[0]
    force = values.astype(np.float32).astype(np.float64)
    run = (OnnxStream if kind == "stream" else OnnxBatch)(model.SerializeToString())
    report = compare(run.score(force, **film), found.score(force, **film), found.settling, _version())
    entry = {"kind": kind, "detector": describe(found), "settling": found.settling, "parity": report.to_dict()}
    add_metadata(model, {METADATA_KEY: json.dumps(entry, sort_keys=True)})
    _write(Path(path), model.SerializeToString(deterministic=True))
    return report


def build_model(detector: DifferenceDetector, kind: Kind, n_taxels: int, size: tuple[int, int] | None) -> ModelProto:
    """The checked graph of a detector that `export_onnx` takes; `size` is the frames' height and width."""
    g = Graph(stream=kind == "stream")
    force = force_input(g, n_taxels)
    treated, missing = differences(g, force, detector, n_taxels)
    score_output(g, _score(g, detector, treated, n_taxels, size), missing)
    return g.model(f"slip_{type(detector).__name__.lower()}_{kind}")


def describe(detector: DifferenceDetector) -> dict[str, Any]:
    """Class and parameters of a detector, ready for JSON."""
    scale = None if detector.scale is None else detector.scale.tolist()
    found: dict[str, Any] = {"class": type(detector).__name__, "window": detector.window, "scale": scale}
    found["common_mode"] = detector.common_mode
    if isinstance(detector, Covariance):
        found["side"] = detector.side
    if isinstance(detector, Spectral):
        found |= {"cutoff_hz": detector.cutoff_hz, "rate_hz": detector.rate_hz, "taps": len(detector.coefficients)}
    if isinstance(detector, NeuralForce):
        found["parameters"] = detector.net.shape.parameters
    return found


def _score(g: Graph, detector: DifferenceDetector, treated: str, n_taxels: int, size: tuple[int, int] | None) -> str:
    if isinstance(detector, Covariance):
        return covariance_score(g, treated, detector, n_taxels)
    if isinstance(detector, Energy):
        return energy_score(g, treated, detector, n_taxels)
    if isinstance(detector, Spectral):
        return spectral_score(g, treated, detector, n_taxels)
    assert isinstance(detector, NeuralForce)
    held = None if size is None else held_embedding(g, treated, detector.net, *size)
    return net_score(g, treated, held, detector.net)


def _exportable(detector: Detector, kind: str, n_taxels: int) -> DifferenceDetector:
    if kind not in ("batch", "stream"):
        raise ValueError(f'expected kind to be "batch" or "stream", got {kind!r}')
    # A subclass may score otherwise, so only the classes themselves have a graph.
    if not isinstance(detector, DifferenceDetector) or type(detector) not in EXPORTED:
        names = ", ".join(each.__name__ for each in EXPORTED)
        raise ValueError(f"{type(detector).__name__} has no graph of its own: exported are {names}")
    if detector.nan == "skip":
        raise ValueError('a detector with nan="skip" has no exact graph, which answers NaN: take nan="refuse"')
    taxels = len(detector.scale) if detector.scale is not None else n_taxels
    if isinstance(detector, NeuralForce):
        taxels = detector.net.shape.taxels
    if n_taxels < 1 or taxels != n_taxels:
        raise ValueError(f"expected n_taxels={taxels}, as many as the detector knows, got {n_taxels}")
    return detector


def _version() -> str:
    import onnxruntime

    return str(onnxruntime.__version__)


def _write(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
