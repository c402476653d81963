"""One simulated recording -> one row of the dataset, refused when it is not what was declared."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vtbench.data.meta import Plan
from vtbench.data.png import encode_png
from vtbench.data.table import Row

if TYPE_CHECKING:
    from sensors.recording import Recording


def recording_row(recording: Recording, plan: Plan) -> Row:
    """Row of one sample; ValueError when shapes, labels or finiteness differ from `plan`."""
    labels = recording.labels
    name = str(labels["object"])
    if name not in plan.classes:
        raise ValueError(f"object {name!r} is not one of the {len(plan.classes)} classes of {plan.name}")
    row: dict[str, Any] = {
        "id": str(labels["id"]),
        "object": name,
        "label": plan.classes.index(name),
        "press": str(labels["press"]),
        "unit": int(labels["unit"]),
        "session": int(labels["session"]),
        "round": int(labels["round"]),
        "seed": plan.seed,
        "image": image_cell(recording.image, plan.image_size, f"{labels['id']}.png"),
        "image_rest": image_cell(recording.image_rest, plan.image_size, f"{labels['id']}-rest.png"),
        "force": forces(recording.force, "force", (plan.n_taxels,)),
        "taxel_load": forces(recording.taxel_load, "taxel_load", (plan.n_taxels,)),
        "force_series": forces(recording.force_series, "force_series", (None, plan.n_taxels)),
        "rate_hz": float(recording.rate_hz),
        "hold_start": int(recording.hold[0]),
        "hold_stop": int(recording.hold[1]),
        "image_time_s": float(recording.image_time_s),
        "total_force_n": float(recording.total_force_n),
        "indentation_mm": float(recording.indentation_mm),
        "pose_x_mm": float(labels["pose_x_mm"]),
        "pose_y_mm": float(labels["pose_y_mm"]),
        "pose_deg": float(labels["pose_deg"]),
    }
    for field, grid in plan.truth.items():
        row[f"truth_{field}"] = truth_cell(recording.truth[field], field, grid)
    return row


def image_cell(image: np.ndarray[Any, Any], size: tuple[int, int], path: str) -> tuple[bytes, str]:
    """PNG bytes and a file name for a frame of the declared (height, width)."""
    if image.dtype != np.uint8 or image.shape != (*size, 3):
        raise ValueError(f"image of shape {image.shape} and type {image.dtype}, expected {(*size, 3)} uint8 (RGB)")
    return encode_png(image), path.replace("/", "-")


def forces(
    values: np.ndarray[Any, Any], name: str, shape: tuple[int | None, ...]
) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Newtons as float32, finite and of the declared shape (None: any length)."""
    array = np.asarray(values, np.float32)
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        expected = " x ".join("T" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} of shape {array.shape}, expected {expected} taxels")
    if not np.isfinite(array).all():
        taxel = int(np.argwhere(~np.isfinite(array))[0][-1])
        raise ValueError(f"{name} is not finite at taxel {taxel}")
    return array


def truth_cell(values: np.ndarray[Any, Any], name: str, grid: tuple[int, int]) -> np.ndarray[Any, Any]:
    """A ground-truth field on its declared grid."""
    if values.shape != grid:
        raise ValueError(f"truth {name!r} of shape {values.shape}, expected {grid}")
    return values
