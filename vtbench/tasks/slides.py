"""What slip tasks share: the trials of one or several datasets, what truly happened in them, their splits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Feed, Fold, NotPossibleError, Split, SplitRule, Task, TaskData

if TYPE_CHECKING:
    from slip.alarms import AlarmRule

RULES = {"prior": Feed(()), "cfar": Feed(())}
"""How a threshold is found; either way the detector sees the taxel forces."""
PROBES = {"total-force": Feed(())}
"""The sum of the taxels alone: a change of load shows in it, the pattern of a slip hardly does."""
RECOVERED = "incipient"
"""Kind of trial that slips in part and recovers: an alarm there is neither a detection nor a false alarm."""
MOVED = ("slide", "rotation", RECOVERED)
"""Kinds that begin with a rest, from which `cfar` learns the noise."""


@dataclass(frozen=True)
class SlideTruth:
    """What happened in one trial, in samples of its force.

    Attributes:
        onset, end: first sample of gross slip and the one after its last, None without.
        partial: first sample of partial slip before that, None without.
        rest: samples at the start in which the arm surely rests.
        comparable: counts in the ROC, whose trials must be alike in length.
    """

    kind: str
    object: str
    samples: int
    rate_hz: float
    onset: int | None
    end: int | None
    partial: int | None
    rest: int
    comparable: bool
    speed: str
    load: str
    direction: str


@dataclass(eq=False)
class SlideData(TaskData):
    """Trials of a slip task; forces are read when asked for.

    Attributes:
        paths: folders of the datasets.
        truth: (n,) what happened.
        at: (n, 2) dataset and row of each trial.
    """

    paths: tuple[Path, ...] = ()
    truth: tuple[SlideTruth, ...] = ()
    at: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 2), np.int64))

    def each_force(self, trials: Sequence[int] | NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.float32]]]:
        """(trial, forces (T, taxels)) of the trials, in the order of their shards."""
        from vtbench.data.slide_reader import SlideDataset

        chosen = np.asarray(trials, np.int64)
        for number, path in enumerate(self.paths):
            mine = chosen[self.at[chosen, 0] == number]
            mine = mine[np.argsort(self.at[mine, 1], kind="stable")]
            if len(mine):
                dataset = SlideDataset.open(path, verify=False)
                yield from zip(mine.tolist(), dataset.each_series(self.at[mine, 1]), strict=True)

    def frames(self, trial: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        """Frames (F, height, width, 3) of a trial and their times (F,) in seconds; none where they were not kept."""
        from vtbench.data.slide_reader import SlideDataset

        dataset, row = self.at[trial].tolist()
        try:
            return SlideDataset.open(self.paths[dataset], verify=False).frames(row)
        except ValueError:
            return np.empty((0, 0, 0, 3), np.uint8), np.empty(0)

    def states(self, trials: Sequence[int]) -> dict[int, NDArray[np.uint8]]:
        """State of the contact (T,) of each of the trials: 0 stick, 1 partial slip, 2 gross slip."""
        from vtbench.data.slide_reader import SlideDataset

        found: dict[int, NDArray[np.uint8]] = {}
        for number, path in enumerate(self.paths):
            mine = [trial for trial in trials if self.at[trial, 0] == number]
            if mine:
                rows = self.at[mine, 1]
                found |= dict(zip(mine, SlideDataset.open(path, verify=False).states(rows), strict=True))
        return found


@dataclass(frozen=True)
class SlipTask(Task):
    """A task whose methods are slip detectors.

    Attributes:
        periods, early_s, settle_s, refractory_s: when a score is an alarm, see `slip.AlarmRule`.
        window: of the detectors, in samples.
        cfar_rate: false alarms a sample that `cfar` is asked for, before hold-on.
        rates: false alarms a minute at which delays are compared.
    """

    periods: int = 3
    early_s: float = 0.25
    settle_s: float = 0.5
    refractory_s: float = 1.0
    cfar_rate: float = 1e-3
    window: int = 50
    rates: tuple[float, ...] = (0.1, 1.0, 10.0)

    @property
    def rule(self) -> AlarmRule:
        """The alarm rule."""
        from slip.alarms import AlarmRule

        return AlarmRule(self.periods, self.refractory_s, self.early_s, self.settle_s)

    def protocol(self) -> dict[str, Any]:
        """JSON values that decide a result beside split and detector."""
        names = ("periods", "early_s", "settle_s", "refractory_s", "cfar_rate", "window")
        return {**{name: getattr(self, name) for name in names}, "rates_per_min": list(self.rates)}


def load_slides(paths: Sequence[Path]) -> SlideData:
    """Trials of the datasets in `paths`; those of the first count in the ROC."""
    from vtbench.data.slide_reader import SlideDataset

    ids: list[str] = []
    truth: list[SlideTruth] = []
    units: list[str] = []
    at: list[tuple[int, int]] = []
    for number, path in enumerate(paths):
        dataset = SlideDataset.open(path, verify="sha256")
        columns = dataset.columns()
        rest_s = _rest_s(dataset.meta.scene)
        for row, (state, onset) in enumerate(zip(dataset.states(), dataset.onsets(), strict=True)):
            line = columns.iloc[row]
            truth.append(_truth(line, state, onset, rest_s, comparable=number == 0))
            ids.append(f"{dataset.meta.name}/{line['id']}")
            units.append(f"{line['unit']}")
            at.append((number, row))
    objects, labels = np.unique([each.object for each in truth], return_inverse=True)
    return SlideData(
        ids=np.array(ids),
        labels=labels.astype(np.int64),
        classes=tuple(objects.tolist()),
        factors={"object": np.array([each.object for each in truth]), "unit": np.array(units)},
        rows=np.arange(len(ids)),
        sources={},
        paths=tuple(paths),
        truth=tuple(truth),
        at=np.array(at, np.int64),
    )


def _rest_s(scene: dict[str, Any] | None) -> float:
    """Seconds at the start of a moved trial before which the scene never moves."""
    motion = (scene or {}).get("motion", {})
    return max(float(motion.get("rest_s", 0.0)) - float(motion.get("rest_jitter_s", 0.0)), 0.0)


def _truth(line: Any, state: NDArray[np.uint8], onset: int | None, rest_s: float, *, comparable: bool) -> SlideTruth:
    gross, some = np.flatnonzero(state == 2), np.flatnonzero(state > 0)
    turns = float(line["rotation_deg_s"])
    moved = line["kind"] in MOVED
    return SlideTruth(
        kind=str(line["kind"]),
        object=str(line["object"]),
        samples=len(state),
        rate_hz=float(line["rate_hz"]),
        onset=onset,
        end=int(gross[-1]) + 1 if len(gross) else None,
        partial=int(some[0]) if len(some) else None,
        rest=min(round(rest_s * float(line["rate_hz"])), len(state)) if moved else 0,
        comparable=comparable and line["kind"] != RECOVERED,
        speed=f"{abs(turns):g} deg/s" if turns else f"{float(line['speed_mm_s']):g} mm/s",
        load=f"{float(line['load_n']):g} N",
        direction=f"{float(line['direction_deg']):g} deg",
    )


def held_out_object(data: TaskData, seed: int) -> Split:
    """Every object's trials in turn, with thresholds from trials with the other objects."""
    objects = data.factor("object")
    levels = np.unique(objects)
    if len(levels) < 2:
        raise NotPossibleError(f"there is one object only ({levels[0]}), so none can be held out")
    folds = tuple(
        Fold(f"object-{level}", np.flatnonzero(objects != level), np.flatnonzero(objects == level)) for level in levels
    )
    return Split("held-out-object", folds, data.ids.astype(np.str_), "trial")


def random_folds(count: int) -> SplitRule:
    """Trials dealt out to `count` parts, every object evenly; each part's thresholds come from the others."""

    def rule(data: TaskData, seed: int) -> Split:
        rng = np.random.default_rng(seed)
        part = np.empty(len(data), np.int64)
        for label in np.unique(data.labels):
            members = rng.permutation(np.flatnonzero(data.labels == label))
            part[members] = np.arange(len(members)) % count
        parts = np.unique(part)
        if len(parts) < 2:
            raise NotPossibleError("no object has two trials to divide between training and test")
        folds = tuple(Fold(f"part-{at}", np.flatnonzero(part != at), np.flatnonzero(part == at)) for at in parts)
        return Split("random", folds, data.ids.astype(np.str_), "trial")

    return rule


def load_one(path: Path, features: object, backbone: str) -> TaskData:
    """Trials of a single dataset; the features are for tasks with frames."""
    return load_slides((path,))
