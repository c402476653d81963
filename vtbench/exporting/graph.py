"""The graph of a fitted pipeline: raw inputs, the features of each block, its reduction, the classifier, scores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from fusion.features import get_backbone
from fusion.onnx import add_estimator
from fusion.onnx.affine import project
from fusion.onnx.builder import Graph
from fusion.onnx.ends import backbone_features, float_input, frame_change, score_output
from fusion.onnx.series import step_means
from fusion.onnx.spectrum import amplitudes, fourier_coefficients, single_precision
from vtbench.exporting.fit import Fitted, Samples
from vtbench.run.fitted import FittedBlock
from vtbench.tasks.presses import STEPS
from vtbench.tasks.texture_fabricslide16 import N_HARMONICS, N_TAXELS

if TYPE_CHECKING:
    from onnx import ModelProto

    from vtbench.onnx_eval.offers import Offer


@dataclass
class Inputs:
    """The raw inputs that the blocks of a graph have asked for.

    Attributes:
        finite: rows that hold finite numbers alone, one mask (N, 1) an input.
    """

    graph: Graph
    offer: Offer
    backbone: str
    finite: list[str] = field(default_factory=list)

    def frames(self, name: str) -> str:
        """A uint8 input (N, height, width, 3)."""
        from onnx import TensorProto

        return self.graph.input(name, TensorProto.UINT8, self._shape(name))

    def numbers(self, name: str) -> str:
        """A float32 input as double, 0 where it is not finite."""
        values, finite = float_input(self.graph, name, self._shape(name))
        self.finite.append(finite)
        return values

    def _shape(self, name: str) -> list[int | str]:
        ports = {port.name: port.shape for port in self.offer.contract.inputs}
        if name not in ports:
            raise ValueError(f"these recordings hold no {name}; they have {', '.join(ports)}")
        return ["N" if size is None else size for size in ports[name] or ()]


def build(samples: Samples, fitted: Fitted, offer: Offer) -> ModelProto:
    """The checked graph of a fitted pipeline.

    Raises:
        ValueError: a block or a classifier that has no exact graph.
    """
    g = Graph()
    inputs = Inputs(g, offer, samples.backbone)
    parts = []
    for name, block in fitted.pipeline.blocks.items():
        if name not in BLOCKS:
            raise ValueError(f"features {name!r} have no graph; use a modality made of {', '.join(BLOCKS)}")
        width = samples.data.block(name).shape[1]
        parts.append(reduced(g, block, BLOCKS[name](inputs), width))
    x = parts[0] if len(parts) == 1 else g.op("Concat", *parts, axis=1)
    classifier = fitted.pipeline.classifier
    scores = add_estimator(g, classifier, x)
    known = np.asarray(classifier.classes_).tolist()  # type: ignore[attr-defined]
    score_output(g, scores, known, len(samples.data.classes), inputs.finite)
    return g.model("pipeline")


def reduced(g: Graph, block: FittedBlock, x: str, width: int) -> str:
    """Leading columns, `ModalityPCA` with its leading components, the factor."""
    if block.leading is not None:
        x = g.columns(x, slice(0, block.leading), width)
    if block.transform is None:
        return x if block.scale == 1.0 else g.op("Mul", x, float(block.scale))
    part = next(iter(block.transform._parts.values()))
    inverse = part.scale * block.scale / part.spread  # 0 for a constant column, whose spread is infinite
    if part.axes is None:
        return project(g, x, part.mean, inverse)
    return project(g, x, part.mean, inverse[:, None] * part.axes[: block.size].T)


def _frames(inputs: Inputs, backbone: str) -> str:
    return backbone_features(inputs.graph, get_backbone(backbone), inputs.frames("image"))


def _change(inputs: Inputs, backbone: str) -> str:
    change = frame_change(inputs.graph, inputs.frames("image"), inputs.frames("image_rest"))
    return backbone_features(inputs.graph, get_backbone(backbone), change)


def _in_steps(inputs: Inputs) -> str:
    g = inputs.graph
    return single_precision(g, step_means(g, inputs.numbers("force_series"), STEPS))


def _coefficients(inputs: Inputs) -> str:
    g = inputs.graph
    return single_precision(g, fourier_coefficients(g, inputs.numbers("force_series"), N_HARMONICS))


def _spectrum(inputs: Inputs) -> str:
    g = inputs.graph
    return single_precision(g, amplitudes(g, _coefficients(inputs), N_HARMONICS, N_TAXELS))


BLOCKS: dict[str, Callable[[Inputs], str]] = {
    "force": lambda inputs: inputs.numbers("force"),
    "image": lambda inputs: _frames(inputs, inputs.backbone),
    "image-change": lambda inputs: _change(inputs, inputs.backbone),
    "pixels": lambda inputs: _frames(inputs, "pixels"),
    "pixels-change": lambda inputs: _change(inputs, "pixels"),
    "force-series": _in_steps,
    "coefficients": _coefficients,
    "spectrum": _spectrum,
    "electrodes": lambda inputs: inputs.numbers("force"),
}
"""Features of a block from raw inputs, (N, columns) double."""
