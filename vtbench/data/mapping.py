"""How a folder of recordings in any layout maps to ours: the keys of a mapping file."""

from __future__ import annotations

import re
import string
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from vtbench.data.format import PRESSES

NEWTONS = {"N": 1.0, "mN": 1e-3, "g": 9.80665e-3, "kg": 9.80665}
"""Newtons of one unit; grams and kilograms are weights under standard gravity."""
FIELDS = ("object", "press", "unit", "session")
PLACES = ("folder", "stem", "line")

Names = Annotated[tuple[str, ...], BeforeValidator(lambda value: (value,) if isinstance(value, str) else value)]


class Mapping(BaseModel):
    """A mapping file (YAML).

    Attributes:
        forces: the files of forces below the folder, CSV or NPY; names or patterns such as `*/log_*.csv`.
        each_file: what a file holds: `presses`, one a line, or one `press`, whose lines are samples in time.
        hold: of files that hold one press: the part of their lines that is averaged, as fractions.
        skip_lines: lines above the heading.
        delimiter: what parts the columns; `tab` for a tabulator.
        decimal: the decimal mark.
        taxels: columns of the taxels in their order, or a regular expression that matches their whole names; the
            number in its first group orders them, else they stay in the file's order. NPY files need none.
        force_unit: N, mN, g, kg, or counts.
        newtons_per_count: of counts.
        zero_count: the count at no force.
        object: column that names the object.
        press: column that says deep or shallow; without it every press is deep.
        unit: column that names the sensor.
        session: column that names the session.
        total_force: column of the total normal force, in `force_unit` too (of counts: newtons).
        values: other words for deep and shallow, e.g. `{d: deep, s: shallow}`.
        image: path of a press's image, with columns and groups in braces: `{object}/{frame}.png`; one `*` may stand
            where exactly one file fits. `{folder}`, `{stem}` and `{line}` are the forces' folder, name without
            suffix, and line of the press (from 1).
        rest: path of the image before contact, likewise.
        forces_path: regular expression, searched in a forces file's path; its named groups are values.
        image_path: likewise, in an image's path.
        license: of the recordings, as a URL or SPDX name.
        citation: how to cite them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    forces: Names = ("forces.csv",)
    each_file: Literal["presses", "press"] = "presses"
    hold: tuple[Annotated[float, Field(ge=0, le=1)], Annotated[float, Field(ge=0, le=1)]] = (0.0, 1.0)
    skip_lines: int = Field(default=0, ge=0)
    delimiter: str = ","
    decimal: Literal[".", ","] = "."
    taxels: str | tuple[str, ...] = r"f(\d+)"
    force_unit: Literal["N", "mN", "g", "kg", "counts"] = "N"
    newtons_per_count: float | None = Field(default=None, gt=0)
    zero_count: float = 0.0
    object: str | None = None
    press: str | None = None
    unit: str | None = None
    session: str | None = None
    total_force: str | None = None
    values: dict[str, Literal["deep", "shallow"]] = {}
    image: str
    rest: str | None = None
    forces_path: str | None = None
    image_path: str | None = None
    license: str | None = None
    citation: str | None = None

    @field_validator("delimiter")
    @classmethod
    def _one_character(cls, value: str) -> str:
        mark = "\t" if value in ("tab", "\\t") else value
        if len(mark) != 1:
            raise ValueError(f"expected one character, or tab, got {value!r}")
        return mark

    @field_validator("taxels", "forces_path", "image_path")
    @classmethod
    def _readable(cls, value: str | tuple[str, ...] | None) -> str | tuple[str, ...] | None:
        if isinstance(value, str):
            try:
                re.compile(value)
            except re.error as error:
                raise ValueError(f"not a regular expression: {error}") from None
        elif value is not None and (not value or len(set(value)) < len(value)):
            raise ValueError("expected names of columns, each once")
        return value

    @field_validator("image", "rest")
    @classmethod
    def _template(cls, value: str | None) -> str | None:
        if value is not None:
            try:
                list(string.Formatter().parse(value))
            except ValueError as error:
                raise ValueError(f"not a path with names in braces: {error}") from None
            if Path(value).is_absolute() or ".." in Path(value).parts:
                raise ValueError("expected a path inside the folder")
        return value

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        if (self.force_unit == "counts") != (self.newtons_per_count is not None):
            raise ValueError("newtons_per_count goes with force_unit: counts, and only with it")
        if self.decimal == self.delimiter:
            raise ValueError(f"delimiter and decimal are both {self.decimal!r}")
        if self.hold[0] >= self.hold[1]:
            raise ValueError(f"hold: expected two fractions that grow, got {list(self.hold)}")
        for field in FIELDS:
            if getattr(self, field) is not None and field in self.groups:
                raise ValueError(f"{field}: given by a column and by a group of a path; leave one of the two")
        if self.object is None and "object" not in self.groups:
            raise ValueError(
                "object: name its column, or a group (?P<object>...) of forces_path or image_path, such as "
                "image_path: '(?P<object>[^/]+)/[^/]+$' where folders are named after objects"
            )
        return self

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups of both paths."""
        found = [re.compile(path).groupindex for path in (self.forces_path, self.image_path) if path]
        return tuple(name for names in found for name in names)

    @property
    def names(self) -> tuple[str, ...]:
        """What stands in the braces of both templates."""
        parts = [part for text in (self.image, self.rest or "") for part in string.Formatter().parse(text)]
        return tuple(dict.fromkeys(name for _, name, _, _ in parts if name is not None))

    def press_of(self, text: str) -> str | None:
        """Deep or shallow, in the words of the recordings; None for a word that is unknown."""
        word = self.values.get(text, text)
        return word if word in PRESSES else None


def load_mapping(path: Path) -> Mapping:
    """A mapping file; ValueError of one line with its line, and the closest key to a misspelt one."""
    from vtbench.config import load_model

    return load_model(path, Mapping)
