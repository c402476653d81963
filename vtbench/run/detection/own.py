"""Every detector on somebody's own sequences: thresholds from the other objects, records like any other."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from leaderboard.record import Identity, Record, Status, Timing, record_key
from vtbench.data.slip_folder import REST_LABEL, SlipSequence
from vtbench.run.detection.detect import DetectionWork
from vtbench.run.detection.methods import DETECTORS, plain_detectors, with_baseline
from vtbench.run.detection.scoring import score_slips
from vtbench.run.evaluate import Outcome
from vtbench.tasks.base import Fold, NotPossibleError, Split, Variant
from vtbench.tasks.slides import RULES, SlideData, SlideTruth, SlipTask, held_out_object, load_one

LeaveOut = Literal["object", "sequence"]


@dataclass(eq=False)
class SequenceData(SlideData):
    """Sequences in memory as trials."""

    forces: tuple[NDArray[np.float64], ...] = ()
    onsets_known: bool = True

    def each_force(self, trials: Sequence[int] | NDArray[np.int64]) -> Iterator[tuple[int, NDArray[Any]]]:
        """(trial, forces (T, taxels)) in order."""
        for trial in np.asarray(trials, np.int64).tolist():
            yield trial, self.forces[trial]

    def frames(self, trial: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        """None: these are forces alone."""
        return np.empty((0, 0, 0, 3), np.uint8), np.empty(0)

    def states(self, trials: Sequence[int]) -> dict[int, NDArray[np.uint8]]:
        """State (T,) of each sequence, 2 while it slips.

        Raises:
            ValueError: a sequence with slip does not say when.
        """
        if not self.onsets_known:
            raise ValueError("the sequences with slip have no column 'slip' that says when")
        return {trial: _state(self.truth[trial]) for trial in trials}


def _state(truth: SlideTruth) -> NDArray[np.uint8]:
    state = np.zeros(truth.samples, np.uint8)
    if truth.onset is not None:
        state[truth.onset : truth.end] = 2
    return state


def one_sequence_out(data: SlideData, seed: int) -> Split:
    """Every sequence by itself, with thresholds from all others."""
    everything = np.arange(len(data))
    folds = tuple(Fold(name, np.delete(everything, at), everything[at : at + 1]) for at, name in enumerate(data.ids))
    return Split("held-out-sequence", folds, data.ids.astype(np.str_), "sequence")


TASK = SlipTask(
    id="slip/own/v1",
    about="raise an alarm when the object begins to slip, on sequences of one's own",
    reads="slides",
    load=load_one,
    variants={"own": Variant("sequences from a folder", {"held-out-object": held_out_object})},
    modalities=RULES,
    probes={},
)


def sequence_data(sequences: Sequence[SlipSequence], rate_hz: float) -> SequenceData:
    """Sequences as trials; without a column `slip` the whole of a sequence with slip counts as slipping."""
    truth = tuple(_truth(sequence, rate_hz) for sequence in sequences)
    objects, labels = np.unique([sequence.object for sequence in sequences], return_inverse=True)
    return SequenceData(
        ids=np.array([sequence.path for sequence in sequences]),
        labels=labels.astype(np.int64),
        classes=tuple(objects.tolist()),
        factors={"object": np.array([sequence.object for sequence in sequences])},
        rows=np.arange(len(sequences)),
        sources={},
        truth=truth,
        forces=tuple(sequence.force for sequence in sequences),
        onsets_known=all(sequence.slipping is not None for sequence in sequences if sequence.has_slip),
    )


def _truth(sequence: SlipSequence, rate_hz: float) -> SlideTruth:
    samples = len(sequence.force)
    onset, end, rest = None, None, samples if sequence.label == REST_LABEL else 0
    if sequence.has_slip:
        onset, end = 0, samples
        if sequence.slipping is not None:
            at = np.flatnonzero(sequence.slipping)
            onset, end = int(at[0]), int(at[-1]) + 1
            rest = max(onset - round(0.5 * rate_hz), 0)
    return SlideTruth(
        kind=sequence.label,
        object=sequence.object,
        samples=samples,
        rate_hz=rate_hz,
        onset=onset,
        end=end,
        partial=None,
        rest=rest,
        comparable=True,
        speed="",
        load="",
        direction="",
    )


def score_own(
    data: SequenceData,
    name: str,
    provenance: dict[str, Any],
    *,
    detectors: tuple[str, ...] = (),
    leave_out: LeaveOut = "object",
    window: int = 50,
    timeout_s: float = 600.0,
) -> Iterator[Record]:
    """Records of every detector with both rules of thresholds; what cannot be scored says why.

    Raises:
        ValueError: an unknown detector, or nothing left to learn a threshold from.
    """
    from vtbench.run.executor import attempt

    try:
        split = one_sequence_out(data, 0) if leave_out == "sequence" else held_out_object(data, 0)
    except NotPossibleError as error:
        raise ValueError(
            f"{name}: {error}; the object is the file's name without its number (mug_03.csv: mug). Leave out single "
            "sequences instead with --leave-out sequence"
        ) from None
    task = replace(TASK, window=window)
    content = content_hash(data)
    for rule in RULES:
        for detector in with_baseline(detectors or plain_detectors()):
            identity = Identity(
                task=task.id,
                variant="own",
                split=split.name,
                method=detector,
                modality=rule,
                kind="real",
                params={**DETECTORS.get(detector).identity(), **task.protocol()},
                seed=0,
                dataset=name,
                dataset_hash=content,
                protocol_version=1,
            )
            key = record_key(identity)
            outcome = attempt(DetectionWork(key, detector, rule, split, content, data, task, timeout_s))
            yield _record(identity, outcome, data, task, provenance)


def content_hash(data: SequenceData) -> str:
    """SHA-256 of names, truth and forces."""
    digest = hashlib.sha256()
    for name, truth, force in zip(data.ids.tolist(), data.truth, data.forces, strict=True):
        digest.update(f"{name}|{truth.kind}|{truth.onset}|{truth.end}|{truth.rate_hz}|{force.shape}".encode())
        digest.update(np.ascontiguousarray(force).tobytes())
    return digest.hexdigest()


def _record(
    identity: Identity, outcome: Outcome, data: SequenceData, task: SlipTask, provenance: dict[str, Any]
) -> Record:
    from datetime import UTC, datetime

    from leaderboard.record import Provenance

    metrics = () if outcome.predictions is None else score_slips(outcome.predictions, data, task)
    if not data.onsets_known:  # a delay from the start of a file says nothing
        metrics = tuple(metric for metric in metrics if "delay" not in metric.name)
    moments = [datetime.fromtimestamp(seconds, UTC) for seconds in (outcome.started, outcome.finished)]
    return Record(
        key=record_key(identity),
        identity=identity,
        status=Status(state=outcome.state, reason=outcome.reason),
        metrics=metrics,
        timing=Timing(threads=1, predict_us_per_sample=outcome.predict_us) if metrics else None,
        provenance=Provenance(**provenance, started=moments[0], finished=moments[1]),
    )
