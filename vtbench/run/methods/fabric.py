"""The fabric thesis' classifier: incremental PCA to seven components, then weighted nearest neighbours.

Its parameters are the thesis' own: accuracy saturates at seven components, and ten neighbours vote with exp(-distance).
"""

from __future__ import annotations

from collections.abc import Mapping

from vtbench.run.methods.base import Classifier, Groups, Method, Params

N_COMPONENTS = 7
N_NEIGHBORS = 10


def _incremental(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from sklearn.decomposition import IncrementalPCA
    from sklearn.pipeline import make_pipeline

    from fusion import WeightedKNN

    n_columns = max(columns.stop for columns in groups.values())
    pipeline: Classifier = make_pipeline(
        IncrementalPCA(n_components=min(N_COMPONENTS, n_columns)), WeightedKNN(n_neighbors=N_NEIGHBORS)
    )
    return pipeline


INCREMENTAL = Method(
    "ipca-wknn",
    "incremental PCA to 7 components, 10 nearest neighbours with votes exp(-distance)",
    _incremental,
    preprocess="none",
    source={"n_components": N_COMPONENTS, "n_neighbors": N_NEIGHBORS},
)
