"""Fitted estimators as ONNX graphs: whole pipelines of standard operators, in double precision inside.

`EXPORTERS` maps an estimator's class, as "module:Class", to the function that writes its graph, as "module:function";
both are text, so that nothing is imported before it is needed. Add a class with one line:

    EXPORTERS["fusion.neural.late:LateFusion"] = "fusion.onnx.late:late_fusion"

An exporter is called as `function(graph, estimator, x)` and returns the name of the tensor it made:

graph : `fusion.onnx.builder.Graph`; append nodes with `graph.op("MatMul", x, array)`, or a whole model of one's own
    with `graph.include(model, {"its input": tensor}, "its output")`.
estimator : the fitted estimator.
x : name of a tensor (N, n_features_in_), double, the columns that `predict` takes; always finite.
returns : of a classifier scores (N, len(classes_)), double, in the order of `classes_`, finite, whose first largest is
    the label that `predict` answers; of a transformer what `transform` returns (N, columns), double.

An exporter raises ValueError, in one line that says what to use instead, for settings whose graph would not be exact.
Only the class itself has an exporter: a subclass may answer otherwise. A row must not depend on the rows beside it.

What double precision costs: twice the memory of single precision, and about twice the time outside the image network,
which stays in float32 as it is run everywhere.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fusion.onnx.builder import Graph

_OWN = "fusion.onnx."

EXPORTERS: dict[str, str] = {
    "fusion.sparse_coding:KSC": _OWN + "sparse:sparse_coding",
    "fusion.sparse_coding:JKSC": _OWN + "sparse:sparse_coding",
    "fusion.neighbors:WeightedKNN": _OWN + "neighbors:weighted_neighbors",
    "fusion.neural.estimators:LateFusionNet": _OWN + "neural:fusion_net",
    "fusion.neural.estimators:FusionTransformer": _OWN + "neural:fusion_net",
    "fusion.features.pca:ModalityPCA": _OWN + "affine:modality_pca",
    "sklearn.neighbors._classification:KNeighborsClassifier": _OWN + "neighbors:nearest_neighbors",
    "sklearn.svm._classes:SVC": _OWN + "support_vectors:support_vectors",
    "sklearn.svm._classes:LinearSVC": _OWN + "affine:linear_decision",
    "sklearn.linear_model._ridge:RidgeClassifier": _OWN + "affine:linear_decision",
    "sklearn.linear_model._ridge:RidgeClassifierCV": _OWN + "affine:linear_decision",
    "sklearn.decomposition._pca:PCA": _OWN + "affine:principal_components",
    "sklearn.decomposition._incremental_pca:IncrementalPCA": _OWN + "affine:principal_components",
    "sklearn.preprocessing._data:StandardScaler": _OWN + "affine:standard_scaler",
    "sklearn.pipeline:Pipeline": _OWN + "affine:pipeline",
}


def class_path(estimator: Any) -> str:
    """The key of an estimator's class in `EXPORTERS`: "module:Class"."""
    return f"{type(estimator).__module__}:{type(estimator).__qualname__}"


def add_estimator(graph: Graph, estimator: Any, x: str) -> str:
    """Append a fitted estimator to a graph; see the module for `x` and what is returned.

    A class of scikit-learn without an exporter goes through skl2onnx; its parity is for the caller to measure.

    Raises:
        ValueError: no exact graph; the message says what to use instead.
    """
    path = class_path(estimator)
    if path in EXPORTERS:
        module, _, function = EXPORTERS[path].partition(":")
    elif path.startswith("sklearn."):
        module, function = _OWN + "foreign", "through_skl2onnx"
    else:
        known = ", ".join(sorted({key.partition(":")[2] for key in EXPORTERS}))
        raise ValueError(f"{path} has no ONNX exporter; use one of {known}, or register one in fusion.onnx.EXPORTERS")
    made: str = getattr(import_module(module), function)(graph, estimator, x)
    return made
