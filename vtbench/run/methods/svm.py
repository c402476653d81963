"""Support vector machine with an RBF kernel.

Columns arrive with mean squared norm 1 a modality, so that `gamma` is in units of scikit-learn's "scale".
"""

from __future__ import annotations

from collections.abc import Mapping

from vtbench.run.methods.base import Classifier, Groups, Method, Params


def _svm(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from sklearn.svm import SVC

    return SVC(kernel="rbf", **params)


SVM = Method("svm", "support vector machine, RBF", _svm, {"C": (10.0, 1.0, 100.0), "gamma": (1.0, 0.25)})
