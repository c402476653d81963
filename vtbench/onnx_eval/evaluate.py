"""A model of somebody else's and a task -> a record like any other, whatever the model does."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Metric, Record, State, Status, Timing, write_record
from leaderboard.submission import Artifact
from vtbench.onnx_eval import plan
from vtbench.onnx_eval.handed_in import Credit, Result, copies, record_of
from vtbench.onnx_eval.judge import Judged, judge
from vtbench.onnx_eval.offers import Offer, offer_of
from vtbench.onnx_eval.sandbox import LARGEST_MODEL_MB, Answer, Job, Limits, private_folder, run
from vtbench.onnx_eval.tested import Tested
from vtbench.tasks.base import NotPossibleError

TIMING_NOTE = "indicative: one process, in the sandbox, one thread; first call and batch 1 stand with the artifact"

Predictions = Mapping[str, NDArray[Any]]


@dataclass
class _Course:
    """What is known so far of one evaluation."""

    artifact: Artifact
    state: State = "ok"
    reason: str = ""
    doubts: tuple[str, ...] = ()
    metrics: tuple[Metric, ...] = ()
    timing: Timing | None = None
    predictions: Predictions | None = None
    modality: str = "unknown"


def evaluate(model: Path, tested: Tested, credit: Credit, out: Path, limits: Limits | None = None) -> Record:
    """Run a model on the samples of `tested` in a locked process, score what it gives, write the record under `out`.

    A model that breaks the contract, fails, lies or takes too long has a record too, "failed" or "timeout", with the
    reason in one line. One whose scores depend on the order of the samples is scored and flagged.

    Raises:
        OSError: the model's file cannot be read, or `out` not be written.
    """
    from vtbench.data.files import make_folder

    make_folder(out)
    started = datetime.now(UTC)
    size = model.stat().st_size
    if size > LARGEST_MODEL_MB * 2**20:
        course = _Course(Artifact(sha256=_hash_of_file(model), size_bytes=size))
        course.state, course.reason = "failed", f"a file of {size / 2**20:.0f} MB: expected {LARGEST_MODEL_MB} at most"
    else:
        content = model.read_bytes()
        course = _Course(Artifact(sha256=hashlib.sha256(content).hexdigest(), size_bytes=size))
        _run(content, tested, limits or Limits(), course)
    status = Status(state=course.state, reason=course.reason)
    result = Result(status, course.metrics, course.timing, course.doubts, course.modality)
    others = copies(out, course.artifact.sha256, credit.id)
    record = record_of(result, tested, credit, course.artifact, started, "verified", others)
    write_record(out, record, course.predictions)
    return record


def _run(content: bytes, tested: Tested, limits: Limits, course: _Course) -> None:
    offer = offer_of(tested.task, tested.paths, tested.data)
    with private_folder(content) as folder:
        look = run(folder, offer.contract, Job(), limits)
        _note(look, course)
        if look.state != "ok" or not _agreed(look, offer, course):
            return
        course.modality = tested.modality(look.told.inputs)
        job, order = _prepare(folder, offer, look.told.inputs, tested.samples, limits)
        answer = run(folder, offer.contract, job, limits)
    _note(answer, course)
    if answer.state != "ok":
        return
    lengths = None if offer.lengths is None else offer.lengths[order]
    judged = judge(answer, job, lengths)
    if judged.reason:
        course.state, course.reason = "failed", judged.reason
        return
    course.doubts = (*judged.doubts, *tested.seen_in_fitting(look.told.fitted_on))
    course.timing = _timing(answer, tested, offer)
    try:
        course.predictions, course.metrics = tested.score(_in_place(judged, order), _us(answer, tested, offer))
    except NotPossibleError as error:
        course.state, course.reason, course.timing = "failed", str(error), None


def _agreed(look: Answer, offer: Offer, course: _Course) -> bool:
    """Whether the inputs that the process told are among the offered ones, as it must have checked itself."""
    if look.told.inputs and len(offer.contract.taken(look.told.inputs)) == len(set(look.told.inputs)):
        return True
    course.state, course.reason = "failed", "its process told of inputs that the task does not offer"
    return False


def _prepare(
    folder: Path, offer: Offer, names: tuple[str, ...], samples: NDArray[np.int64], limits: Limits
) -> tuple[Job, NDArray[np.int64]]:
    """The job, and the samples in the shuffled order that the model sees; the order is told to nobody."""
    rng = np.random.default_rng(secrets.randbits(128))
    order = samples[rng.permutation(len(samples))]
    in_time = offer.contract.output.name == "slip_score"
    lengths = offer.lengths[order] if offer.lengths is not None and "force_series" in names else None
    first = plan.batches(np.arange(len(order)), lengths, 1 if in_time else plan.BATCH)
    again = plan.again(len(order), lengths, rng)
    timing = plan.timing(len(order), lengths, limits.time_s, in_time)
    job = Job(
        inputs=offer.write(folder, names, order),
        batches=first,
        recheck=again,
        timing=timing,
        width=0 if in_time else len(_classes(offer)),
        rows=plan.rows_of([first, again, *(each["batches"] for each in timing)], lengths, in_time),
    )
    return job, order


def _classes(offer: Offer) -> range:
    width = (offer.contract.output.shape or ())[1]
    assert isinstance(width, int)
    return range(width)


def _in_place(judged: Judged, order: NDArray[np.int64]) -> dict[int, NDArray[np.float32]]:
    """Scores by sample of the data, out of those by place in the shuffled order."""
    return {int(sample): scores for sample, scores in zip(order, judged.scores, strict=True)}


def _note(answer: Answer, course: _Course) -> None:
    told = answer.told
    more = {
        "parameters": told.parameters,
        "nodes": told.nodes,
        "inputs": told.inputs,
        "load_s": told.load_s,
        "peak_rss_mb": told.peak_rss_mb,
        "latency": answer.latency,
        "runtime": told.runtime,
        "protections": told.protections,
    }
    known = {name: value for name, value in more.items() if value}
    course.artifact = course.artifact.model_copy(update=known)
    course.state, course.reason = answer.state, answer.reason


def _us(answer: Answer, tested: Tested, offer: Offer) -> float:
    """Microseconds a sample on the largest batch; of scores in time, a sample of the force."""
    best = answer.latency[-1]
    length = 1.0
    if tested.in_time:
        assert offer.lengths is not None
        values, counts = np.unique(offer.lengths[tested.samples], return_counts=True)
        length = float(values[counts.argmax()])
    return 1e3 * best.p50_ms / best.batch / length


def _timing(answer: Answer, tested: Tested, offer: Offer) -> Timing:
    return Timing(
        threads=1,
        batch=answer.latency[-1].batch,
        predict_us_per_sample=_us(answer, tested, offer),
        peak_rss_mb=answer.told.peak_rss_mb,
        note=TIMING_NOTE,
    )


def _hash_of_file(path: Path) -> str:
    from vtbench.data.files import sha256_of

    return sha256_of(path)
