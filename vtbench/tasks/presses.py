"""What tasks on presses share: samples of a dataset on disk, their feature blocks, their protocols."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Block, Factor, FeatureCache, Features, Feed, NotPossibleError, TaskData, Variant
from vtbench.tasks.splits import held_out, random_draws

if TYPE_CHECKING:
    from fusion.features.backbone import Backbone

FRAME = Block("image", components=(16, 32, 64), from_frames=True)
CHANGE = Block("image-change", components=FRAME.components, from_frames=True)
FORCE = Block("force")
STEPS = 32
"""Of the force series of a press, from its first sample to its last, whatever its length and rate."""
PIXELS = Block("pixels", shape=(3, 32, 32))
PIXELS_CHANGE = Block("pixels-change", shape=PIXELS.shape)
SERIES = Block("force-series", shape=(STEPS, -1))
_PIXELS_OF = {PIXELS.name: "image", PIXELS_CHANGE.name: "image-change"}
TRUTH_SIDE = 32
"""Side to which a ground-truth grid is averaged; finer than the 20 mm pitch of a taxel by far."""

MODALITIES = {
    "force": Feed((FORCE,)),
    "image": Feed((FRAME,)),
    "image-change": Feed((CHANGE,)),
    "fused": Feed((FRAME, FORCE), weights="chosen"),
    "fused-equal": Feed((FRAME, FORCE)),
    "fused-change": Feed((CHANGE, FORCE), weights="chosen"),
    "pixels-change": Feed((PIXELS_CHANGE,), by_name=True),
    "force-series": Feed((SERIES,), by_name=True),
    "fused-pixels": Feed((PIXELS, SERIES), weights="chosen", by_name=True),
    "fused-pixels-change": Feed((PIXELS_CHANGE, SERIES), weights="chosen", by_name=True),
}
PROBES = {
    "load-centroid": Feed((Block("load-centroid"),)),
    "total-force": Feed((Block("total-force"),)),
    "rest-frame": Feed((Block("rest-frame", components=FRAME.components, from_frames=True),)),
    "shuffled-labels": Feed((FRAME, FORCE), shuffle_labels=True),
}
UPPER_LINES = {
    "true-displacement": Feed((Block("true-displacement", components=FRAME.components),), needs_truth="displacement"),
}


def variants(test_fraction: float) -> dict[str, Variant]:
    """Protocols of an object task whose random draws test `test_fraction` of the presses of an object."""
    first_unit = random_draws(test_fraction=test_fraction, within_first="unit")
    any_unit = random_draws(test_fraction=test_fraction, strata=("unit",))
    unseen_unit = held_out("unit")
    poses = ("label", "pose_x_mm", "pose_y_mm", "pose_deg")
    return {
        "paper": Variant(
            "a pose of its own for each object, re-seating error only; random draws within one unit",
            {"random": first_unit, "held-out-unit": unseen_unit},
        ),
        "default": Variant(
            "centred objects, several units, sessions interleaved over the objects",
            {"random": any_unit, "held-out-unit": unseen_unit},
        ),
        "hard": Variant(
            "a held-out unit and a pose that no training press had",
            {"held-out-unit": held_out("unit", differs=poses)},
        ),
        "no-variation": Variant(
            "the same press again and again",
            {"random": first_unit},
            laws={"force": "perfect", "image": "perfect", "fused": "perfect", "rest-frame": "chance"},
        ),
        "own": Variant(
            "your own recordings: random draws, and each unit or session held out where they name it",
            {"random": any_unit, "held-out-unit": unseen_unit, "held-out-session": held_out("session")},
        ),
    }


def load_presses(path: Path, features: FeatureCache, backbone: str, *, press: Literal["deep", "any"]) -> TaskData:
    """Samples of a dataset of presses; frames and forces are read when a block is asked for.

    Args:
        path: dataset folder.
        features: keeps the frames' features.
        backbone: name of the network that turns frames into features.
        press: `deep` leaves shallow presses out.
    """
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify="sha256")  # results are kept under the hash that it states
    known = [
        name
        for name in ("unit", "session", "press", "pose_x_mm", "pose_y_mm", "pose_deg")
        if name in dataset.meta.columns
    ]
    table = dataset.columns(["id", "label", *known])
    factors: dict[str, Factor] = {name: table[name].to_numpy() for name in known}
    labels = table["label"].to_numpy(np.int64)
    factors["label"] = labels
    if "unit" in factors and "session" in factors:
        factors["session"] = np.array(
            [f"{unit}.{session}" for unit, session in zip(factors["unit"], factors["session"], strict=True)]
        )

    frames = ["image", *(["image-change", "rest-frame"] if "image_rest" in dataset.meta.columns else [])]

    def made_by(block: str) -> tuple[str, str]:
        """Which frames a block is made of, and by which network."""
        return (_PIXELS_OF[block], "pixels") if block in _PIXELS_OF else (block, backbone)

    def identity(block: str) -> dict[str, str]:
        shown, network = made_by(block)
        return {"dataset": dataset.hash, "frames": shown, **backbone_identity(network)}

    def frame_block(block: str) -> Features:
        return features.cached(identity(block), dataset.n, partial(frame_features, path, *made_by(block)))

    def feature_us(block: str) -> float | None:
        return features.us_per_sample(identity(block)) if block in frames else None

    sources: dict[str, Callable[[], Features]] = {
        "force": dataset.force,
        "load-centroid": lambda: load_centroid(dataset.force()),
        "total-force": lambda: dataset.force().sum(1, keepdims=True),
    }
    frames += [block for block, shown in _PIXELS_OF.items() if shown in frames]
    sources |= {block: partial(frame_block, block) for block in frames}
    if "force_series" in dataset.meta.columns:
        sources[SERIES.name] = lambda: in_steps(dataset.force_series(), STEPS)
    if "displacement" in dataset.meta.truth:
        sources["true-displacement"] = lambda: averaged(dataset.truth("displacement"), TRUTH_SIDE)
    data = TaskData(
        ids=table["id"].to_numpy(np.str_),
        labels=labels,
        classes=tuple(dataset.classes),
        factors=factors,
        rows=np.arange(dataset.n),
        sources=sources,
        feature_us=feature_us,
    )
    if press == "deep" and "press" in factors:
        return data.take(factors["press"] == "deep")
    return data


def backbone_identity(name: str) -> dict[str, str]:
    """What decides a backbone's features: its name and the SHA-256 of its weights."""
    from fusion.features import is_own_file

    network = _backbone(name)
    return {"backbone": network.name if is_own_file(name) else name, "backbone_sha256": network.weights_sha256}


def frame_features(path: Path, block: str, backbone: str, rows: NDArray[np.int64]) -> Features:
    """Backbone features (rows, columns) float32 of frames, of rest frames, or of the change between the two."""
    from vtbench.data import Dataset

    dataset = Dataset.open(path, verify=False)
    if block == "rest-frame":
        images = dataset.images(rows, column="image_rest")
    else:
        images = dataset.images(rows)
        if block == "image-change":
            images = change(images, dataset.images(rows, column="image_rest"))
    return _backbone(backbone).extract(images)


def change(frames: NDArray[np.uint8], rest: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Frames minus rest frames about mid-grey, uint8: what the press changed, without the cloth and light of a unit."""
    return np.clip(frames.astype(np.int16) - rest + 128, 0, 255).astype(np.uint8)


def _backbone(name: str) -> Backbone:
    """The network, loaded once a process; a file of one's own again where it was written anew."""
    from fusion.features import is_own_file

    file = Path(name).expanduser()
    stamp = (file.stat().st_mtime_ns, file.stat().st_size) if is_own_file(name) and file.is_file() else None
    return _loaded(name, stamp)


@cache
def _loaded(name: str, stamp: tuple[int, int] | None) -> Backbone:
    from fusion.features import get_backbone

    return get_backbone(name)


def load_centroid(force: Features) -> Features:
    """Centroid (n, 2) of the taxel forces (n, taxels), in taxel pitches from the corner of a square array.

    Readings below zero count as zero; a press that no taxel feels has its centroid in the middle.
    """
    side = round(force.shape[1] ** 0.5)
    if side * side == force.shape[1]:
        y, x = np.divmod(np.arange(force.shape[1]), side)
    else:
        y, x = np.zeros(force.shape[1]), np.arange(force.shape[1])
    load = np.maximum(force, 0).astype(np.float64)
    load[load.sum(1) == 0] = 1.0
    centroid: Features = ((load @ np.stack([x, y], 1)) / load.sum(1, keepdims=True)).astype(np.float32)
    return centroid


def in_steps(series: Sequence[NDArray[np.floating]], steps: int) -> Features:
    """Force histories, each (T, taxels), as rows (n, steps * taxels): the mean over each of `steps` equal parts.

    A part that begins or ends within a sample takes its share of it, so that no sample counts more than another. The
    mean is the filter against aliasing: a box as wide as a step, with zeros at every multiple of the step rate.

    Raises:
        NotPossibleError: a history without a sample.
    """
    if not all(len(each) for each in series):
        raise NotPossibleError("a press has no force history")
    rows = []
    for each in series:
        total = np.vstack([np.zeros(each.shape[1]), np.cumsum(each, axis=0, dtype=np.float64)])
        edges = np.linspace(0, len(each), steps + 1)
        whole = np.minimum(edges.astype(np.int64), len(each) - 1)
        upto = total[whole] + (edges - whole)[:, None] * (total[whole + 1] - total[whole])
        rows.append((np.diff(upto, axis=0) * (steps / len(each))).ravel())
    return np.array(rows, np.float32)


def averaged(grids: NDArray[np.generic], side: int) -> Features:
    """Grids (n, rows, columns) averaged over cells to at most `side` x `side`, as rows (n, side * side)."""
    n, rows, columns = grids.shape
    by_row, by_column = max(1, rows // side), max(1, columns // side)
    cut = grids[:, : rows // by_row * by_row, : columns // by_column * by_column].astype(np.float32)
    blocks = cut.reshape(n, rows // by_row, by_row, columns // by_column, by_column)
    return np.asarray(blocks.mean((2, 4)).reshape(n, -1), np.float32)
