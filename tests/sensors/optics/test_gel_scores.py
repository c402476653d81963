"""L1, SSIM and PSNR: what is known of them without having run them."""

import numpy as np
import pytest

from sensors.optics.image_scores import image_scores, structural_similarity


def noise(seed=0, shape=(48, 56, 3)) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def by_hand(a: np.ndarray, b: np.ndarray) -> float:
    """The paper's formula, window by window, with the window's weights written out."""
    offset = np.arange(11) - 5
    weight = np.exp(-(offset**2) / (2 * 1.5**2))
    window = np.outer(weight, weight) / weight.sum() ** 2
    views = [np.lib.stride_tricks.sliding_window_view(x.astype(float), (11, 11)) for x in (a, b)]
    mean = [(view * window).sum(axis=(-2, -1)) for view in views]
    centred = [view - m[..., None, None] for view, m in zip(views, mean, strict=True)]
    var = [(c**2 * window).sum(axis=(-2, -1)) for c in centred]
    cov = (centred[0] * centred[1] * window).sum(axis=(-2, -1))
    c1, c2 = 2.55**2, 7.65**2
    score = (2 * mean[0] * mean[1] + c1) * (2 * cov + c2)
    return float((score / ((mean[0] ** 2 + mean[1] ** 2 + c1) * (var[0] + var[1] + c2))).mean())


def test_equal_frames_score_best():
    same = image_scores(noise(), noise())
    assert (same.l1, same.psnr_db) == (0.0, float("inf"))
    assert same.ssim == pytest.approx(1.0)


def test_ssim_is_the_papers_formula():
    a, b = noise(0)[..., 0], noise(1)[..., 0]
    blend = (0.7 * a + 0.3 * b).astype(np.uint8)
    assert structural_similarity(a, blend) == pytest.approx(by_hand(a, blend), rel=1e-10)


def test_ssim_of_flat_frames_is_its_luminance_term():
    a, b = 100.0, 140.0
    expected = (2 * a * b + 2.55**2) / (a**2 + b**2 + 2.55**2)
    assert structural_similarity(np.full((20, 20), a), np.full((20, 20), b)) == pytest.approx(expected, rel=1e-9)


def test_ssim_is_symmetric_and_low_without_a_common_structure():
    a, b = noise(0), noise(1)
    assert structural_similarity(a, b) == pytest.approx(structural_similarity(b, a), rel=1e-12)
    assert abs(structural_similarity(a, b)) < 0.05
    assert structural_similarity(a, 255 - a) < -0.5


def test_ssim_of_channels_is_the_mean_of_their_own():
    a, b = noise(0), (0.5 * noise(0) + 0.5 * noise(1)).astype(np.uint8)
    each = [structural_similarity(a[..., c], b[..., c]) for c in range(3)]
    assert structural_similarity(a, b) == pytest.approx(np.mean(each), rel=1e-12)


def test_a_constant_offset_has_its_l1_and_psnr():
    a = np.full((20, 20, 3), 100, np.uint8)
    scores = image_scores(a, a + 3)
    assert scores.l1 == 3.0
    assert scores.psnr_db == pytest.approx(20 * np.log10(255 / 3))


def test_differences_do_not_wrap_around():
    black, white = np.zeros((16, 16, 3), np.uint8), np.full((16, 16, 3), 255, np.uint8)
    assert image_scores(black, white).l1 == image_scores(white, black).l1 == 255.0
    assert image_scores(black, white).psnr_db == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        (noise(), noise()[1:], "one shape"),
        (noise()[:5], noise()[:5], "at least 11"),
        (noise(), noise().astype(float), "uint8"),
    ],
)
def test_other_input_is_refused(a, b, message):
    with pytest.raises(ValueError, match=message):
        image_scores(a, b)
