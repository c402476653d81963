"""One simulated slide -> one row of the dataset, refused when it is not what was declared."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vtbench.data.format import SLIDE_STATES
from vtbench.data.meta import Plan
from vtbench.data.rows import forces, image_cell
from vtbench.data.slide_checks import first_gross
from vtbench.data.table import Row

if TYPE_CHECKING:
    from sensors.slide import SlideRecording


def slide_row(recording: SlideRecording, plan: Plan) -> Row:
    """Row of one trial; ValueError when shapes, labels, states or finiteness differ from `plan`."""
    labels = recording.labels
    name = str(labels["object"])
    if name not in plan.classes:
        raise ValueError(f"object {name!r} is not one of the {len(plan.classes)} objects of {plan.name}")
    if float(recording.rate_hz) != plan.rate_hz:
        raise ValueError(f"a rate of {recording.rate_hz:g} Hz, expected {plan.rate_hz} Hz")
    series = forces(recording.force_series, "force_series", (None, plan.n_taxels))
    row: dict[str, Any] = {
        "id": str(labels["id"]),
        "object": name,
        "label": plan.classes.index(name),
        "kind": str(labels["kind"]),
        "trial": int(labels["trial"]),
        "unit": int(labels["unit"]),
        "session": int(labels["session"]),
        "seed": plan.seed,
        **{key: float(labels[key]) for key in ("speed_mm_s", "rotation_deg_s", "load_n", "direction_deg")},
        "rate_hz": float(recording.rate_hz),
        "onset": recording.onset_sample,
        "force_series": series,
        "state": _state(recording, len(series)),
    }
    if "frames" in plan.columns:
        frames = recording.frames if recording.frames is not None else np.empty((0, 0, 0, 3), np.uint8)
        row["frames"] = [
            image_cell(frame, plan.image_size, f"{labels['id']}-{number:04d}.png")
            for number, frame in enumerate(frames)
        ]
        row["frame_time_s"] = np.asarray(recording.frame_time_s, np.float64)
    return row


def _state(recording: SlideRecording, samples: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    state = np.asarray(recording.state, np.uint8)
    if state.shape != (samples,) or (samples and state.max() >= len(SLIDE_STATES)):
        raise ValueError(f"state of shape {state.shape}, expected {samples} values in 0..{len(SLIDE_STATES) - 1}")
    if first_gross(state) != recording.onset_sample:
        raise ValueError(f"onset at sample {recording.onset_sample}, the state slips from {first_gross(state)} on")
    return state
