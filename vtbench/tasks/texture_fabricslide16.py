"""Which of seven fabrics does the finger slide over? Real recordings of 16 capacitive taxels.

Data: FabricSlide16, 966 slides of one 600 mm stroke each, 141 to 2117 samples of raw counts.
Features: each taxel z-scored over the recording, then a Fourier basis with a fundamental of one period a stroke, fitted
by least squares. The stroke is the same at every speed, so harmonic k is a spatial frequency, k periods in 600 mm, and
speed drops out. The number of harmonics is chosen on training folds, up to 70: the most that the shortest recording
determines (2 x 70 + 1 coefficients from 141 samples).
On these recordings the folds choose 5 or 10, the fewest: waves of 60 mm and more, far longer than any thread. What
tells the fabrics apart is then the slow profile of a strip and its board as much as the cloth.
Modalities: `spectrum` keeps the amplitude of each harmonic, because where a thread lies at the start of a slide says
nothing about the fabric; `coefficients` keeps sine and cosine, which also know where on the strip of fabric, and on its
board, a load was felt.
Target: the fabric. Splits: ten stratified draws at 9:1, and each of the five grip settings held out in turn.
Metrics: accuracy, balanced accuracy. Intervals: over recordings for random draws, over settings when held out.
Probes: mean levels of the taxels; mean and standard deviation of the two proximity channels, which are no taxels;
shuffled labels. A fabric is also one recording session: these probes show how much of a score the session gives.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Block, FeatureCache, Features, Feed, Task, TaskData, Variant
from vtbench.tasks.splits import held_out, random_draws

N_TAXELS = 16
N_HARMONICS = 70
HARMONICS_TRIED = (5, 10, 20, 35, 70)


def load(path: Path, cache: FeatureCache, backbone: str) -> TaskData:
    """All slides over fabrics below `path`; boards are left out. `backbone` is for tasks with frames."""
    from vtbench.data import load_fabricslide16

    slides = load_fabricslide16(path)
    classes, labels = np.unique(slides.fabric, return_inverse=True)
    fitted: dict[str, Features] = {}

    def coefficients() -> Features:
        if "coefficients" not in fitted:
            fitted["coefficients"] = harmonics(slides.series)
        return fitted["coefficients"]

    sources: dict[str, Callable[[], Features]] = {
        "spectrum": lambda: amplitudes(coefficients()),
        "coefficients": coefficients,
        "mean-levels": lambda: _stack([series.mean(0) for series in slides.series]),
        "proximity": lambda: _stack([np.concatenate([p.mean(0), p.std(0)]) for p in slides.proximity]),
    }
    return TaskData(
        ids=np.array(slides.path),
        labels=labels.astype(np.int64),
        classes=tuple(classes.tolist()),
        factors={"setting": slides.setting, "speed": slides.speed, "repetition": slides.repetition},
        rows=np.arange(len(slides)),
        sources=sources,
    )


def harmonics(series: list[NDArray[np.float64]]) -> Features:
    """Coefficients (n, harmonics * 2 * taxels) of z-scored series: by harmonic, then sine and cosine, then taxel."""
    from fusion.features import FourierBasis

    fitted = FourierBasis(n_harmonics=N_HARMONICS).fit(series).transform(series)
    return np.asarray(fitted, np.float32)


def amplitudes(coefficients: Features) -> Features:
    """Amplitude (n, harmonics * taxels) of each harmonic and taxel, by harmonic."""
    pairs = coefficients.reshape(len(coefficients), -1, 2, N_TAXELS)
    return np.hypot(pairs[:, :, 0], pairs[:, :, 1]).reshape(len(coefficients), -1)


def _stack(rows: list[NDArray[np.float64]]) -> Features:
    return np.stack(rows).astype(np.float32)


_SPECTRUM = Block("spectrum", leading=tuple(N_TAXELS * k for k in HARMONICS_TRIED))

TASK = Task(
    id="texture/fabricslide16/v1",
    about="name the fabric from one slide over it",
    reads="fabricslide16",
    load=load,
    variants={
        "public": Variant(
            "every recording of a fabric in the public set",
            {
                "random": random_draws(test_fraction=1 / 10, group_kind="recording"),
                "held-out-setting": held_out("setting"),
            },
        )
    },
    modalities={
        "spectrum": Feed((_SPECTRUM,)),
        "coefficients": Feed((Block("coefficients", leading=tuple(2 * N_TAXELS * k for k in HARMONICS_TRIED)),)),
    },
    probes={
        "mean-levels": Feed((Block("mean-levels"),)),
        "proximity": Feed((Block("proximity"),)),
        "shuffled-labels": Feed((_SPECTRUM,), shuffle_labels=True),
    },
)
