"""Kernel sparse coding, one kernel or one for each modality.

Columns arrive with mean squared norm 1 a modality, so that `gamma` is in units of scikit-learn's "scale".
"""

from __future__ import annotations

from collections.abc import Mapping

from vtbench.run.methods.base import Classifier, Groups, Method, Params

_CHOICES = {"gamma": (1.0, 0.25, 4.0), "n_nonzero_coefs": (10, 4)}


def _ksc(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    from fusion import KSC

    return KSC(**params)


def _jksc(coupling: str) -> Method:
    def build(groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
        from fusion import JKSC

        return JKSC(modalities=dict(groups), weights=dict(weights), coupling=coupling, **params)

    shared = coupling == "shared"
    return Method(
        id="jksc" if shared else "jksc-independent",
        about="joint kernel sparse coding, " + ("one support for all modalities" if shared else "a code for each"),
        build=build,
        choices=_CHOICES,
        joint=True,
        weighs_groups=True,
    )


KSC_METHOD = Method("ksc", "kernel sparse coding on all columns", _ksc, _CHOICES)
SHARED = _jksc("shared")
INDEPENDENT = _jksc("independent")
