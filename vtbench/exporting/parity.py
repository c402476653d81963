"""How far a graph's answers are from those of the pipeline it was made of, on real samples, and what a call costs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fusion.onnx import EXPORTERS, class_path

if TYPE_CHECKING:
    from vtbench.onnx_eval.offers import Offer
    from vtbench.run.methods.base import Classifier

BATCH = 100
CALLS = {1: 20, BATCH: 3}
TIE_UNITS = 2.0
"""Best two scores within so many units in the last place of float32, which a graph answers in, are a tie."""
TOLERANCE = 1e-3
"""Largest difference of scores, as a part of the row's largest score, that an export may have."""

Feed = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Parity:
    """What was measured.

    Attributes:
        samples: real samples compared.
        ties: of them, those whose best two scores are a tie; they are left out of the agreement.
        agreement: part of the others whose label is the pipeline's.
        largest_difference: between a score of the graph and the pipeline's.
        relative_difference: the same, as a part of the row's largest score.
        batch_difference: between a sample's scores alone and in a batch.
        nan_rows: whether a row with NaN, and only that one, scored NaN.
        latency_1_ms, latency_100_ms: median of a call with one sample and with a hundred, one thread.
    """

    samples: int
    ties: int
    agreement: float
    largest_difference: float
    relative_difference: float
    batch_difference: float
    nan_rows: bool
    latency_1_ms: float
    latency_100_ms: float
    onnxruntime: str

    def as_json(self) -> dict[str, Any]:
        """Plain values, as they stand in the file's metadata."""
        return asdict(self)

    def problem(self) -> str:
        """Why the graph is not the pipeline; empty where it is."""
        if self.agreement < 1.0:
            return f"its labels agree on {self.agreement:.4f} of {self.samples - self.ties} samples, expected all"
        if not self.relative_difference <= TOLERANCE:
            return f"its scores differ by {self.relative_difference:.2g} of the largest, expected at most {TOLERANCE:g}"
        if not self.nan_rows:
            return "a row with NaN does not score NaN, or spoils others"
        return ""


def reference(classifier: Classifier, x: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Places in `classes_` that `predict` answers (q,), and scores (q, classes) whose first largest they are.

    Scores are `decision_function` or `predict_proba`; where a tie of votes makes `predict` answer another class than
    the first largest of them, that class is raised to it. One column for two classes becomes minus and plus half.
    """
    known = np.asarray(classifier.classes_)  # type: ignore[attr-defined]
    place = np.searchsorted(known, classifier.predict(x))
    score = getattr(classifier, "decision_function", None) or classifier.predict_proba  # type: ignore[attr-defined]
    if _through_skl2onnx(classifier) and hasattr(classifier, "predict_proba"):
        score = classifier.predict_proba  # which is what skl2onnx answers
    scores = np.array(score(x), np.float64)
    if scores.ndim == 1:
        scores = np.stack([-0.5 * scores, 0.5 * scores], 1)
    rows = np.arange(len(scores))
    scores[rows, place] = scores.max(1)
    return place, scores


def _through_skl2onnx(classifier: Any) -> bool:
    """Whether the last step of a pipeline, or the classifier itself, is scikit-learn's and has no exporter of ours."""
    last = classifier.steps[-1][1] if hasattr(classifier, "steps") else classifier
    return class_path(last).startswith("sklearn.") and class_path(last) not in EXPORTERS


def measure(content: bytes, offer: Offer, rows: NDArray[np.int64], classifier: Classifier, x: NDArray[Any]) -> Parity:
    """Run a graph on samples `rows` and compare it with the classifier on their columns `x`."""
    import onnxruntime

    call, names = _session(content)
    known = np.asarray(classifier.classes_, np.int64)  # type: ignore[attr-defined]
    place, expected = reference(classifier, x)
    feeds = _feeds(offer, names, rows)
    found = np.concatenate([call(feed) for feed in feeds])
    best = np.sort(expected, 1)[:, -2:].astype(np.float32)
    tie = best[:, 1] - best[:, 0] <= TIE_UNITS * np.spacing(np.abs(best).max(1))
    right = found.argmax(1) == known[place]
    apart = np.abs(found[:, known] - expected).max(1)
    first = _cut(feeds[0], 1)
    small = _cut(feeds[0], 5)
    alone = np.concatenate([call(_row(small, i)) for i in range(len(next(iter(small.values()))))])
    latency = {size: _latency(call, feeds, size) for size in CALLS}
    untied = int(np.sum(~tie))
    return Parity(
        samples=len(rows),
        ties=int(tie.sum()),
        agreement=float(right[~tie].mean()) if untied else 1.0,
        largest_difference=float(apart.max()),
        relative_difference=float((apart / np.maximum(np.abs(expected).max(1), np.finfo(np.float32).tiny)).max()),
        batch_difference=float(np.abs(alone - call(small)).max()),
        nan_rows=bool(np.isfinite(found).all()) and _answers_nan(call, first),
        latency_1_ms=latency[1],
        latency_100_ms=latency[BATCH],
        onnxruntime=str(onnxruntime.__version__),
    )


def _session(content: bytes) -> tuple[Callable[[Feed], NDArray[np.float32]], list[str]]:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    return lambda feed: session.run(["scores"], feed)[0], [each.name for each in session.get_inputs()]


def _feeds(offer: Offer, names: list[str], rows: NDArray[np.int64]) -> list[Feed]:
    """Batches of real samples; one sample each where their lengths differ."""
    if "force_series" in names:
        assert offer.series is not None
        series = {int(row): np.asarray(values, np.float32)[None] for row, values in offer.series(rows)}
        beside = [name for name in names if name != "force_series"]
        return [
            {"force_series": series[row], **{name: offer.plain[name](np.array([row])) for name in beside}}
            for row in rows.tolist()
        ]
    return [
        {name: offer.plain[name](rows[start : start + BATCH]) for name in names} for start in range(0, len(rows), BATCH)
    ]


def _row(feed: Feed, row: int) -> Feed:
    return {name: np.ascontiguousarray(values[row : row + 1]) for name, values in feed.items()}


def _cut(feed: Feed, count: int) -> Feed:
    return {name: np.ascontiguousarray(values[:count]) for name, values in feed.items()}


def _answers_nan(call: Callable[[Feed], NDArray[np.float32]], one: Feed) -> bool:
    """Whether every value that is not finite makes its row NaN, in every float input, and leaves its neighbours."""
    whole = call(one)
    for name, values in one.items():
        if values.dtype != np.float32:
            continue
        for bad in (np.nan, np.inf, -np.inf):
            pair = {key: np.repeat(each, 2, axis=0) for key, each in one.items()}
            pair[name][0].flat[-1] = bad
            found = call(pair)
            if not np.isnan(found[0]).all() or not np.allclose(found[1], whole[0], rtol=1e-5, atol=1e-6):
                return False
    return True


def _latency(call: Callable[[Feed], NDArray[np.float32]], feeds: list[Feed], size: int) -> float:
    """Median milliseconds of a call with `size` samples, inputs in turn; a short set is repeated to that size."""
    times = []
    for number, feed in zip(range(CALLS[size] + 1), _in_turn(feeds, size), strict=False):
        start = time.perf_counter_ns()
        call(feed)
        if number:
            times.append(time.perf_counter_ns() - start)
    return float(np.median(times)) / 1e6


def _in_turn(feeds: list[Feed], size: int) -> Iterator[Feed]:
    by_length = sorted(feeds, key=lambda feed: feed["force_series"].shape[1] if "force_series" in feed else 0)
    middle = by_length[len(by_length) // 2]  # recordings of the middle length, where lengths differ
    count = len(next(iter(middle.values())))
    number = 0
    while True:
        rows = (np.arange(size) + number) % count
        yield {name: np.ascontiguousarray(values[rows]) for name, values in middle.items()}
        number += size
