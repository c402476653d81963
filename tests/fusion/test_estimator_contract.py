"""Every public estimator passes scikit-learn's own checks, without exemptions."""

import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

from fusion import JKSC, KSC, WeightedKNN
from fusion.features import FourierBasis, ModalityPCA, ResampledSpectrum


@parametrize_with_checks(
    [KSC(), JKSC(coupling="independent"), WeightedKNN(), ModalityPCA(), FourierBasis(), ResampledSpectrum()]
)
def test_estimator_passes(estimator, check):
    check(estimator)


@pytest.mark.slow
@parametrize_with_checks(
    [
        KSC("linear"),
        KSC("precomputed"),
        KSC(solver="lasso"),
        JKSC(),
        JKSC(store_gram=False),
        WeightedKNN(novelty_threshold=0.0),
        ModalityPCA(n_components=3),
        FourierBasis(3, period=20.0),
    ]
)
def test_estimator_passes_in_other_settings(estimator, check):
    check(estimator)
