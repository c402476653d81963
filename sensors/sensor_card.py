"""What a dataset says of the sensor that made it."""

from __future__ import annotations

from typing import Any

from sensors.fvsight import FORCE_RATE_HZ, TAXELS_PER_SIDE
from sensors.optics.camera import CameraParameters
from sensors.scene import PressScene


def describe(scene: PressScene) -> dict[str, Any]:
    """The sensor of a scene as JSON-ready values: its parameters, array, rates and frame."""
    parameters = scene.effective_sensor()
    rows, columns = CameraParameters(view=parameters.view).shape
    return {
        "name": "fvsight",
        "taxels": TAXELS_PER_SIDE**2,
        "taxel_rows": TAXELS_PER_SIDE,
        "taxel_pitch_mm": parameters.region_mm / TAXELS_PER_SIDE,
        "force_unit": "N",
        "rate_hz": FORCE_RATE_HZ,
        "image_rows": rows,
        "image_columns": columns,
        "parameters": parameters.model_dump(mode="json"),
    }
