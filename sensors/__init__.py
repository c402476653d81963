"""Scenes in, paired recordings out: contact, taxel electronics and optics of simulated tactile sensors."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sensors.digit import Digit, DigitParameters
    from sensors.fvsight import FVSightParameters, FVSightUnit
    from sensors.gelsight import GelSight, GelSightParameters
    from sensors.press import TRUTH_FIELDS, simulate
    from sensors.recording import Recording
    from sensors.scene import PressScene
    from sensors.sensor_card import describe
    from sensors.slide import SLIDE_TRUTH, SlideRecording, SlipScene, draw_slide, simulate_slide

__all__ = [
    "SLIDE_TRUTH",
    "TRUTH_FIELDS",
    "Digit",
    "DigitParameters",
    "FVSightParameters",
    "FVSightUnit",
    "GelSight",
    "GelSightParameters",
    "PressScene",
    "Recording",
    "SlideRecording",
    "SlipScene",
    "describe",
    "draw_slide",
    "simulate",
    "simulate_slide",
]

_HOME = {
    "SLIDE_TRUTH": "slide",
    "TRUTH_FIELDS": "press",
    "Digit": "digit",
    "DigitParameters": "digit",
    "FVSightParameters": "fvsight",
    "FVSightUnit": "fvsight",
    "GelSight": "gelsight",
    "GelSightParameters": "gelsight",
    "PressScene": "scene",
    "Recording": "recording",
    "SlideRecording": "slide",
    "SlipScene": "slide",
    "describe": "sensor_card",
    "draw_slide": "slide",
    "simulate": "press",
    "simulate_slide": "slide",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
