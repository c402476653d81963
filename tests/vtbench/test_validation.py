from dataclasses import dataclass
from typing import Annotated, Literal

import pytest
from pydantic import AllowInfNan, BaseModel, ConfigDict, Field, ValidationError, model_validator

from vtbench.validation import dotted, one_line


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Gel(_Part):
    kind: Literal["gel"] = "gel"
    thickness_mm: float = Field(gt=0)


class Canvas(_Part):
    kind: Literal["canvas"] = "canvas"
    weave_mm: float = 0.3


@dataclass
class Clock:
    rate_hz: float
    offset_s: float = 0.0


class Camera(_Part):
    width: int = Field(256, ge=1)
    shutter: Clock | None = None


class Sensor(_Part):
    camera: Camera = Camera()
    cameras: list[Camera] = []
    surface: Gel | Canvas = Canvas()
    by_name: dict[str, Camera] = {}
    view: Literal["crop", "full"] = "crop"
    span_mm: tuple[float, float] = (0.0, 1.0)
    loads_n: tuple[Annotated[float, AllowInfNan(False)], ...] = Field((5.0,), min_length=1)

    @model_validator(mode="after")
    def _ordered(self):
        if self.span_mm[0] > self.span_mm[1]:
            raise ValueError(f"span_mm: expected low before high, got {list(self.span_mm)}")
        return self


def line_for(data, lines=None, source="sensor.yaml"):
    with pytest.raises(ValidationError) as failure:
        Sensor.model_validate(data)
    text = one_line(failure.value, Sensor, data, source, lines)
    assert "\n" not in text
    return text


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ({"camra": 1}, "camra: unknown key; did you mean 'camera' or 'cameras'?"),
        ({"camera": {"widht": 1}}, "camera.widht: unknown key; did you mean 'width'?"),
        ({"cameras": [{}, {"widht": 1}]}, "cameras[1].widht: unknown key; did you mean 'width'?"),
        ({"by_name": {"left": {"widht": 1}}}, "by_name.left.widht: unknown key; did you mean 'width'?"),
        (
            {"camera": {"shutter": {"rate_hz": 1, "rate_hs": 1}}},
            "camera.shutter.rate_hs: unknown key; did you mean 'rate_hz'?",
        ),
        ({"camera": {"width": -3}}, "camera.width: expected a value greater than or equal to 1, got -3"),
        ({"camera": {"width": "wide"}}, "camera.width: expected an integer, got 'wide'"),
        ({"camera": [1]}, "camera: expected a mapping of width, shutter, got [1]"),
        ({"view": "ful"}, "view: expected 'crop' or 'full', got 'ful'; did you mean 'full'?"),
        ({"view": 3}, "view: expected 'crop' or 'full', got 3"),
        ({"span_mm": [2, 1]}, "span_mm: expected low before high, got [2.0, 1.0]"),
        ({"camera": {"shutter": {}}}, "camera.shutter.rate_hz: expected this key, got nothing"),
        ({"loads_n": []}, "loads_n: expected at least 1 item, got []"),
        ({"loads_n": [float("nan")]}, "loads_n[0]: expected a finite number, got nan"),
        ({"span_mm": 3}, "span_mm: expected a list such as [3], got 3"),
        ({"cameras": "left"}, "cameras: expected a list, got 'left'"),
    ],
)
def test_a_problem_is_key_expected_and_got(data, expected):
    assert line_for(data) == f"sensor.yaml: {expected}"


def test_the_members_of_a_union_are_not_part_of_the_key():
    text = line_for({"surface": {"kind": "gel", "thickness_mm": -1}})
    assert text.startswith("sensor.yaml: surface.")
    assert "Gel" not in text.partition(" (and")[0].replace("for Gel", "")


def test_an_unknown_key_in_a_union_is_matched_against_all_members():
    assert "did you mean 'weave_mm'?" in line_for({"surface": {"weav_mm": 1.0}})


def test_further_problems_are_counted_once_for_each_key():
    text = line_for({"camera": {"width": 0}, "view": "x", "cameras": 3})
    assert text.endswith("(and 2 more problems)")
    assert line_for({"camera": {"width": 0}, "view": "x"}).endswith("(and 1 more problem)")


def test_a_misspelt_key_comes_before_the_key_that_is_missing_for_it():
    assert "rate_hs: unknown key" in line_for({"camera": {"shutter": {"rate_hs": 1}}})


def test_the_line_is_the_keys_or_that_of_the_closest_key_above():
    lines = {("camera",): 3, ("camera", "width"): 4}
    assert line_for({"camera": {"width": 0}}, lines).startswith("sensor.yaml:4: camera.width")
    assert line_for({"camera": {"shutter": {}}}, lines).startswith("sensor.yaml:3: camera.shutter.rate_hz")


def test_a_line_of_zero_was_not_written_in_the_file():
    lines = {("camera",): 3, ("camera", "width"): 0}
    assert line_for({"camera": {"width": 0}}, lines).startswith("sensor.yaml: camera.width")


def test_without_a_source_the_line_begins_with_the_key():
    assert line_for({"view": 3}, source="").startswith("view: ")


def test_a_long_value_is_cut():
    assert len(line_for({"camera": {"width": "x" * 500}})) < 150


def test_a_key_path_reads_as_one_writes_it():
    assert dotted(("entries", 0, "methods", 2)) == "entries[0].methods[2]"
    assert dotted(()) == ""
