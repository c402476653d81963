"""Methods by id. A new one is a `Method` in a file here and a line below."""

from vtbench.registry import Registry
from vtbench.run.methods import fabric, neighbors, neural, sparse, svm
from vtbench.run.methods.base import Classifier, Method

METHODS: Registry[Method] = Registry("method", see="vtbench list methods")

for _method in (
    sparse.KSC_METHOD,
    sparse.SHARED,
    sparse.INDEPENDENT,
    neighbors.UNIFORM,
    neighbors.WEIGHTED,
    svm.SVM,
    fabric.INCREMENTAL,
    neural.LATE_FUSION,
    neural.TRANSFORMER,
    neural.LATE_FUSION_WHOLE,
    neural.TRANSFORMER_WHOLE,
):
    METHODS.register(_method.id)(_method)

__all__ = ["METHODS", "Classifier", "Method"]
