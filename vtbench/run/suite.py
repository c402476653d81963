"""What a suite file may say: datasets, entries of the grid, and methods of one's own."""

from __future__ import annotations

import re
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue, field_validator, model_validator

from vtbench.registry import unknown
from vtbench.run.detection.methods import DETECTORS
from vtbench.run.methods import METHODS
from vtbench.tasks import TASKS

DEFAULT_BACKBONE = "efficientnet-lite0"
JOIN = "+"
"""Between the ids of datasets that one variant reads together."""


def _plain_word(text: str) -> str:
    """An id that is a folder's name, and a part of tables and of joined names."""
    if not re.fullmatch(r"[a-z0-9][a-z0-9_.-]*", text):
        raise ValueError(f"expected a word of small letters, digits, '_', '-' and '.', got {text!r}")
    return text


_Id = Annotated[str, AfterValidator(_plain_word)]


def dataset_ids(joined: str) -> list[str]:
    """The datasets that a variant reads, from their joined name."""
    return joined.split(JOIN)


def known_backbone(name: str) -> str:
    """The name itself, or the path of an ONNX file, which is opened later.

    Raises:
        ValueError: no backbone of that name, with the closest one.
    """
    from fusion.features import backbone_names, is_own_file

    if not is_own_file(name) and name not in backbone_names():
        raise unknown("backbone", name, backbone_names(), "vtbench list backbones")
    return name


def opened_backbone(name: str) -> str:
    """The same after a look into the file, where it is one.

    Raises:
        ValueError: no such name, or a file that is no backbone.
    """
    from fusion.features import get_backbone, is_own_file

    if is_own_file(known_backbone(name)):
        get_backbone(name)
    return name


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class DatasetSpec(_Part):
    """Presses or slides to simulate, or a folder that holds a dataset.

    Attributes:
        id: name of the dataset; entries find it as the variant of that name.
        scene: scene to simulate, such as `fvsight-press/hard`, or a YAML file of one's own beside the suite.
        path: folder of a dataset instead, relative to the current folder.
        samples: number of presses or trials, the scene's full protocol by default.
        seed: run seed.
        truth: ground-truth fields to keep.
        frames: of slides: keep the camera's frames too.
        set: values laid over the scene, by dotted key.
    """

    id: _Id
    scene: str | None = None
    path: str | None = None
    samples: int | None = Field(None, ge=1)
    seed: int = Field(0, ge=0)
    truth: tuple[str, ...] = ()
    frames: bool = False
    set: dict[str, JsonValue] = {}

    @field_validator("truth")
    @classmethod
    def _fields_exist(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        from vtbench.data.format import TRUTH_UNITS

        for name in value:
            if name not in TRUTH_UNITS:
                raise unknown("field", name, TRUTH_UNITS)
        return value

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.scene is None) == (self.path is None):
            raise ValueError(f"dataset {self.id!r}: expected a scene or a path, one of the two")
        of_a_scene = (self.samples, self.seed, self.truth, self.frames, self.set)
        if self.path is not None and of_a_scene != (None, 0, (), False, {}):
            named = "samples, seed, truth, frames and set"
            raise ValueError(f"dataset {self.id!r}: {named} belong to a scene, not to a path")
        return self


class Entry(_Part):
    """One task's part of the grid: every variant x split x modality x method, and what stands beside it.

    Attributes:
        task: task id.
        variants: protocols, each on the dataset of the same id, or a mapping of protocol to dataset id; a slip task
            reads several, given as a list, together.
        splits: names of splits; those that the variant has, by default.
        modalities: names of feeds; all of the task by default.
        methods: ids of registered methods or of the suite's own; of a slip task ids of detectors.
        probes: methods that are fed the probes; all of `methods` where nothing is said, none where false.
        upper_lines: methods that are fed the upper lines.
        backbone: what turns frames into features, in place of the suite's; a name, or the path of an ONNX file.
    """

    task: str
    variants: dict[str, str | None]
    splits: tuple[str, ...] | None = Field(None, min_length=1)
    modalities: tuple[str, ...] | None = Field(None, min_length=1)
    methods: tuple[str, ...] = Field(min_length=1)
    probes: tuple[str, ...] | bool = True
    upper_lines: tuple[str, ...] | bool = False
    backbone: str | None = None

    @field_validator("backbone")
    @classmethod
    def _backbone_exists(cls, value: str | None) -> str | None:
        return None if value is None else known_backbone(value)

    @field_validator("variants", mode="before")
    @classmethod
    def _by_name(cls, value: Any) -> Any:
        """A list of variants means datasets of the same ids; a list of datasets is read together."""
        if isinstance(value, list | tuple):
            return dict.fromkeys(value)
        if not isinstance(value, dict):
            return value
        return {
            variant: JOIN.join(map(str, dataset)) if isinstance(dataset, list | tuple) else dataset
            for variant, dataset in value.items()
        }

    @model_validator(mode="after")
    def _names_exist(self) -> Self:
        task = TASKS.get(self.task)
        for variant in self.variants:
            if variant not in task.variants:
                raise unknown(f"variant of {task.id}", variant, task.variants)
        known = {name: None for variant in self.variants for name in task.variants[variant].splits}
        for split in self.splits or ():
            if split not in known:
                raise unknown(f"split of {task.id}", split, known)
        for modality in self.modalities or ():
            if modality not in task.modalities:
                raise unknown(f"modality of {task.id}", modality, task.modalities)
        return self

    def beside(self, what: tuple[str, ...] | bool) -> tuple[str, ...]:
        """Methods of a `probes` or `upper_lines` key."""
        if isinstance(what, bool):
            return self.methods if what else ()
        return what


class OwnMethod(_Part):
    """A scikit-learn classifier by import path, with parameters, and choices made on training folds."""

    estimator: str
    params: dict[str, JsonValue] = {}
    choose: dict[str, tuple[JsonValue, ...]] = {}

    @field_validator("choose")
    @classmethod
    def _something_to_choose(cls, value: dict[str, tuple[JsonValue, ...]]) -> dict[str, tuple[JsonValue, ...]]:
        for name, values in value.items():
            if not values:
                raise ValueError(f"{name}: expected at least one value to choose from")
        return value


class Suite(_Part):
    """A benchmark to run: datasets, and the entries of the grid.

    Attributes:
        seed: draws random splits and shuffled labels.
        backbone: what turns frames into features; a name, or the path of an ONNX file.
        timeout_s: a cell that takes longer is stopped and recorded as such.
    """

    id: _Id
    title: str
    seed: int = Field(0, ge=0)
    backbone: str = DEFAULT_BACKBONE
    timeout_s: float = Field(1800.0, gt=0)
    datasets: tuple[DatasetSpec, ...] = ()
    methods: dict[str, OwnMethod] = {}
    entries: tuple[Entry, ...] = Field(min_length=1)

    @field_validator("backbone")
    @classmethod
    def _backbone_exists(cls, value: str) -> str:
        return known_backbone(value)

    @model_validator(mode="after")
    def _names_exist(self) -> Self:
        ids = [dataset.id for dataset in self.datasets]
        if len(set(ids)) != len(ids):
            raise ValueError(f"datasets: an id is given twice among {', '.join(ids)}")
        for name in self.methods:
            if name in METHODS:
                raise ValueError(f"methods: {name!r} is the id of a built-in method, choose another")
        for entry in self.entries:
            detects = TASKS.get(entry.task).reads == "slides"
            known = [*DETECTORS.ids()] if detects else [*METHODS.ids(), *self.methods]
            for name in (*entry.methods, *entry.beside(entry.probes), *entry.beside(entry.upper_lines)):
                if name not in known:
                    kind, see = ("detector", DETECTORS.see) if detects else ("method", METHODS.see)
                    raise unknown(kind, name, known, see)
            if TASKS.get(entry.task).reads_dataset:
                for variant, joined in entry.variants.items():
                    for dataset in dataset_ids(joined or variant):
                        if dataset not in ids:
                            raise unknown(f"dataset of {entry.task}, variant {variant}:", dataset, ids)
        return self
