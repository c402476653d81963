"""Configurations by name or path: scenes with their variations, suites, and any pydantic model from YAML."""

from __future__ import annotations

import copy
import difflib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from vtbench.paths import configs_dir
from vtbench.registry import unknown
from vtbench.yaml_file import KeyPath, YamlFile, read_yaml

if TYPE_CHECKING:
    import pydantic

    from sensors.scene import PressScene
    from sensors.slide import SlipScene
    from vtbench.run.suite import Suite

    ModelT = TypeVar("ModelT", bound=pydantic.BaseModel)

VARIATIONS = "variations"
SCENE_KINDS = {"press": "objects pressed under force control", "slide": "pressed, then moved sideways"}
_OF_SUITES = {"entries", "datasets"}
"""Keys that a suite has and a scene never."""

_OWN_FILE = re.compile(r"(.+\.ya?ml)(?:/([^/]+))?")
_VARIATION = re.compile(r"[^\s/\\|.][^\s/\\|]*")


def deep_merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `over` laid on it: mappings merge key by key, anything else is replaced. Neither is changed."""
    merged = {key: copy.deepcopy(value) for key, value in base.items()}
    for key, value in over.items():
        below = merged.get(key)
        if isinstance(below, dict) and isinstance(value, Mapping):
            merged[key] = deep_merge(below, value)
        else:
            merged[key] = copy.deepcopy(value)
    return merged


def from_dotted(settings: Mapping[str, Any]) -> dict[str, Any]:
    """`{"pose.shift_mm": 4}` as the nested mapping `{"pose": {"shift_mm": 4}}`.

    Raises:
        ValueError: a key is empty between its dots, or sets both a value and something inside it.
    """
    nested: dict[str, Any] = {}
    for key, value in settings.items():
        *parents, last = key.split(".")
        if not all([*parents, last]):
            raise ValueError(f"expected a key such as 'pose.shift_mm', got {key!r}")
        here: Any = nested
        for parent in parents:
            here = here.setdefault(parent, {})
            if not isinstance(here, dict):
                raise ValueError(f"{key!r} is set, and so is a key above it: leave one of the two")
        if last in here:
            raise ValueError(f"{key!r} is set twice: leave one of the two")
        here[last] = copy.deepcopy(value)
    return nested


def load_model(path: Path, model: type[ModelT], *, data: Mapping[str, Any] | None = None) -> ModelT:
    """Validate a YAML file as a pydantic model.

    Args:
        path: the file; it names the place of a problem.
        model: class to build.
        data: what to validate instead of the file's content, e.g. after merging.

    Raises:
        ValueError: one line with file, line, key path, expected and got; a close match for an unknown key.
    """
    if data is not None:
        return _build(model, dict(data), str(path), {})
    file = read_yaml(path)
    return _build(model, file.data, str(path), file.lines)


def load_scene(
    name_or_path: str | Path, overrides: Mapping[str, Any] | None = None, said: str = ""
) -> PressScene | SlipScene:
    """A scene by name (`fvsight-press/hard`) or from one's own YAML file (`mine.yaml`, `mine.yaml/hard`).

    It is one of presses, or with `kind: slide` one of slides.

    The chosen entry of the file's `variations` is merged over its other keys and added to the scene's id. An empty
    variation is the scene itself under a second name, so it keeps the id.

    Args:
        name_or_path: the scene.
        overrides: values to set on top, by dotted key: `{"pose.reseat_mm": 4}`.
        said: where the overrides are written, to be named instead of the scene's file when they are at fault.

    Raises:
        ValueError: unknown scene or variation (with the closest names), or a value that the scene refuses.
    """
    path, variation = _locate("scene", str(name_or_path))
    file = read_yaml(path)
    if _OF_SUITES & file.data.keys():
        raise ValueError(f"{path}: this is a suite, not a scene: {_instead('scene', str(path))}")
    data = {key: value for key, value in file.data.items() if key != VARIATIONS}
    lines = dict(file.lines)
    if variation:
        variations = _variations(file)
        if variation not in variations:
            raise unknown(f"variation of {path.stem}", variation, variations)
        data = deep_merge(data, variations[variation])
        lines |= {at[2:]: line for at, line in file.lines.items() if at[:2] == (VARIATIONS, variation) and at[2:]}
        if variations[variation]:
            data["id"] = f"{data.get('id', path.stem)}/{variation}"
    if not overrides:
        return _scene(data, str(path), lines)
    try:
        merged = deep_merge(data, from_dotted(overrides))
        return _scene(merged, "", {}) if said else _scene(merged, str(path), _unwritten(lines, overrides))
    except ValueError as error:
        if not said:
            raise
        _scene(data, str(path), lines)  # a scene that is wrong by itself is named
        raise ValueError(f"{said}: {error}") from None


def _unwritten(lines: Mapping[KeyPath, int], overrides: Mapping[str, Any]) -> dict[KeyPath, int]:
    """Lines of a file's keys, none of those that were set from outside."""
    return dict(lines) | {tuple(key.split(".")): 0 for key in overrides}


def _scene(data: dict[str, Any], source: str, lines: Mapping[KeyPath, int]) -> PressScene | SlipScene:
    kind = data.get("kind", "press")
    if kind not in list(SCENE_KINDS):
        line = lines.get(("kind",))
        where = f"{source}:{line}: " if source and line else f"{source}: " if source else ""
        known = " or ".join(f"{name!r} ({about})" for name, about in SCENE_KINDS.items())
        near = difflib.get_close_matches(str(kind).lower(), SCENE_KINDS, n=1, cutoff=0.4)
        raise ValueError(
            f"{where}kind: expected {known}, got {kind!r}" + (f"; did you mean {near[0]!r}?" if near else "")
        )
    if kind == "slide":
        from sensors.slide import SlipScene

        return _build(SlipScene, data, source, lines)
    from sensors.scene import PressScene

    return _build(PressScene, data, source, lines)


def load_suite(name_or_path: str | Path) -> Suite:
    """A suite by name (`quick`) or from one's own YAML file.

    A scene's own file stands beside the suite's file, else below the current folder; the file of a backbone of one's
    own is named from the suite's folder.

    Raises:
        ValueError: unknown suite (with the closest names), a value that it refuses, or a file that is no backbone.
    """
    path, variation = _locate("suite", str(name_or_path))
    if variation:
        raise ValueError(f"{path}: a suite has no variations, got {variation!r} behind its name")
    from vtbench.run.suite import Suite

    file = read_yaml(path)
    if not _OF_SUITES & file.data.keys() and _is_of_a_scene(file.data):
        raise ValueError(f"{path}: this is a scene, not a suite: {_instead('suite', str(path))}")
    suite = _build(Suite, file.data, str(path), file.lines)
    datasets = [spec.model_copy(update={"scene": _beside(path, spec.scene)}) for spec in suite.datasets]
    entries = [entry.model_copy(update={"backbone": _backbone(path, entry.backbone)}) for entry in suite.entries]
    own = {"datasets": tuple(datasets), "entries": tuple(entries), "backbone": _backbone(path, suite.backbone)}
    return suite.model_copy(update=own)


def _is_of_a_scene(keys: Mapping[str, Any]) -> bool:
    """Whether a key belongs to scenes and not to suites."""
    from sensors.scene import PressScene
    from sensors.slide import SlipScene
    from vtbench.run.suite import Suite

    of_scenes = {VARIATIONS, *PressScene.model_fields, *SlipScene.model_fields}
    return bool((of_scenes - Suite.model_fields.keys()) & keys.keys())


def _instead(asked: str, name: str) -> str:
    """What to do with a suite where a scene was asked for, and the other way round."""
    if asked == "scene":
        return f"`vtbench run {name} -o DIR` runs it"
    return f"`vtbench generate {name} -o DIR` makes a dataset of it, and a suite's dataset takes it as `scene: {name}`"


def _beside(suite: Path, scene: str | None) -> str | None:
    """A scene's own file as seen from the current folder, where it stands beside the suite; else what was written."""
    own = _OWN_FILE.fullmatch(scene or "")
    return str(suite.parent / own[0]) if own and (suite.parent / own[1]).is_file() else scene


def _backbone(suite: Path, name: str | None) -> str | None:
    """A backbone as written, or the whole path of one's own file, as seen from the suite's folder."""
    from fusion.features import is_own_file
    from vtbench.run.suite import opened_backbone

    if name is None or not is_own_file(name):
        return name

    try:
        return opened_backbone(str((suite.parent / Path(name).expanduser()).resolve()))
    except ValueError as error:
        raise ValueError(f"{suite}: backbone: {error}") from None


def scene_names() -> list[str]:
    """Every scene that comes with vtbench, each followed by its variations."""
    names = []
    for name, path in _files("scene").items():
        names += [name, *(f"{name}/{key}" for key, chosen in _variations(read_yaml(path)).items() if chosen)]
    return names


def suite_names() -> list[str]:
    """Every suite that comes with vtbench."""
    return list(_files("suite"))


def variation_names(name_or_path: str | Path) -> list[str]:
    """Names under `variations` of a scene, in the file's order; none of a scene that is a variation itself."""
    path, variation = _locate("scene", str(name_or_path))
    return [] if variation else list(_variations(read_yaml(path)))


def _build(model: type[ModelT], data: dict[str, Any], source: str, lines: Mapping[KeyPath, int]) -> ModelT:
    import pydantic

    from vtbench.validation import one_line

    try:
        return model.model_validate(data)
    except pydantic.ValidationError as error:
        raise ValueError(one_line(error, model, data, source, lines)) from None


def _files(kind: str) -> dict[str, Path]:
    folder = configs_dir() / f"{kind}s"
    paths = sorted(folder.rglob("*.yaml"))
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in paths}


def _locate(kind: str, name: str) -> tuple[Path, str]:
    """File of a configuration and the variation asked for (empty: none), from its name or path."""
    own = _OWN_FILE.fullmatch(name)
    if own:
        return Path(own[1]).expanduser(), own[2] or ""
    files = _files(kind)
    if name in files:
        return files[name], ""
    base, _, variation = name.rpartition("/")
    if base in files and variation:
        return files[base], variation
    other = "suite" if kind == "scene" else "scene"
    if name in (suite_names() if kind == "scene" else scene_names()):
        raise ValueError(f"{name!r} is a {other}, not a {kind}: {_instead(kind, name)}")
    known = scene_names() if kind == "scene" else list(files)
    raise unknown(kind, name, known, f"vtbench list {kind}s")


def _variations(file: YamlFile) -> dict[str, dict[str, Any]]:
    found = file.data.get(VARIATIONS) or {}
    where = f"{file.path}:{file.lines.get((VARIATIONS,), 1)}: {VARIATIONS}"
    if not isinstance(found, dict):
        raise ValueError(f"{where}: expected a mapping of names to changed keys, got {found!r}")
    for name, changes in found.items():
        if not isinstance(name, str) or not _VARIATION.fullmatch(name):
            raise ValueError(f"{where}: expected a name without '/', '|' or blanks, got {name!r}")
        if not isinstance(changes, dict | type(None)):
            raise ValueError(f"{where}.{name}: expected a mapping of changed keys, got {changes!r}")
    return {name: changes or {} for name, changes in found.items()}
