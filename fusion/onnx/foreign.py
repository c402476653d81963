"""Estimators of scikit-learn that have no exporter here, through skl2onnx; whether they are exact is then measured."""

from __future__ import annotations

from typing import Any

from fusion.onnx.builder import OPSET, Graph
from fusion.onnx.ends import halves

ML_OPSET = 3


def through_skl2onnx(g: Graph, estimator: Any, x: str) -> str:
    """The scores (N, classes), or what a transformer returns, of skl2onnx's graph, as double.

    Raises:
        ValueError: skl2onnx does not convert it.
    """
    from onnx import TensorProto
    from skl2onnx import convert_sklearn
    from skl2onnx.common.data_types import DoubleTensorType

    name = type(estimator).__name__
    classifies = hasattr(estimator, "classes_")
    types = [("x", DoubleTensorType([None, estimator.n_features_in_]))]
    options: dict[Any, Any] = {type(estimator): {"zipmap": False}} if classifies else {}
    try:
        model = convert_sklearn(
            estimator, initial_types=types, options=options, target_opset={"": OPSET, "ai.onnx.ml": ML_OPSET}
        )
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise ValueError(f"{name}: skl2onnx does not convert it ({reason}); use ksc, knn, wknn or svm") from error
    output = model.graph.output[1 if classifies else 0].name
    made = g.op("Cast", g.include(model, {"x": x}, output), to=TensorProto.DOUBLE)
    if (
        classifies
        and len(estimator.classes_) == 2
        and model.graph.output[1].type.tensor_type.shape.dim[-1].dim_value == 1
    ):
        return halves(g, made)
    return made
