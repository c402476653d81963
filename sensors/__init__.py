"""Scenes in, paired recordings out: contact, taxel electronics and optics of simulated tactile sensors."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sensors.catalogue import SENSORS
    from sensors.cpm_finger import FABRICS, CPMFinger, CPMFingerParameters, Fabric
    from sensors.digit import Digit, DigitParameters
    from sensors.fvsight import FVSightParameters, FVSightUnit
    from sensors.gelsight import GelSight, GelSightParameters
    from sensors.press import TRUTH_FIELDS, simulate
    from sensors.recording import Recording
    from sensors.scene import PressScene
    from sensors.sensor_card import describe
    from sensors.slide import SLIDE_TRUTH, SlideRecording, SlipScene, draw_slide, simulate_slide
    from sensors.taxel_pad import TaxelPad, TaxelPadParameters
    from sensors.two_pad_grasp import Grasp, lift_cube

__all__ = [
    "FABRICS",
    "SENSORS",
    "SLIDE_TRUTH",
    "TRUTH_FIELDS",
    "CPMFinger",
    "CPMFingerParameters",
    "Digit",
    "DigitParameters",
    "FVSightParameters",
    "FVSightUnit",
    "Fabric",
    "GelSight",
    "GelSightParameters",
    "Grasp",
    "PressScene",
    "Recording",
    "SlideRecording",
    "SlipScene",
    "TaxelPad",
    "TaxelPadParameters",
    "describe",
    "draw_slide",
    "lift_cube",
    "simulate",
    "simulate_slide",
]

_HOME = {
    "FABRICS": "cpm_finger",
    "SENSORS": "catalogue",
    "SLIDE_TRUTH": "slide",
    "TRUTH_FIELDS": "press",
    "CPMFinger": "cpm_finger",
    "CPMFingerParameters": "cpm_finger",
    "Digit": "digit",
    "DigitParameters": "digit",
    "FVSightParameters": "fvsight",
    "FVSightUnit": "fvsight",
    "Fabric": "cpm_finger",
    "GelSight": "gelsight",
    "GelSightParameters": "gelsight",
    "Grasp": "two_pad_grasp",
    "PressScene": "scene",
    "Recording": "recording",
    "SlideRecording": "slide",
    "SlipScene": "slide",
    "TaxelPad": "taxel_pad",
    "TaxelPadParameters": "taxel_pad",
    "describe": "sensor_card",
    "draw_slide": "slide",
    "lift_cube": "two_pad_grasp",
    "simulate": "press",
    "simulate_slide": "slide",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
