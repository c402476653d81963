"""The contact models and grids that a scene could take: measured errors, whose they are, and what was not measured."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import median

from sensors.explain import Grid
from sensors.fvsight import FVSightParameters
from sensors.grids.choose import BOUNDS, GridChoice, measured_choices
from sensors.grids.table import committed_grids
from sensors.scene import PressScene
from sensors.slide.scene import SlipScene

MODELS = {
    "hollow": "a hollow skin has one contact model (skin): an error bound takes its grid",
    "plate": "a film on a plate has two contact models (springs, layer): an error bound takes model and grid; the "
    "errors above are against the same linear film, and a bound counts the finite strain of the film on top",
}
"""What an error bound can choose from, by the sensor's support."""
SLIDES = "a slip scene takes no error bound: model and grid are the sensor's own, and their errors are not measured"

ByClass = dict[str, dict[tuple[int, str], GridChoice]]


def press_grids(scene: PressScene) -> tuple[Grid, ...]:
    """Every measured model and grid for a press scene's pad, and the one it takes."""
    bound = scene.error_bound.named() if scene.error_bound else {}
    sensor = scene.effective_sensor()
    try:
        known = _by_class(scene.sensor, scene.object_classes, scene.loads_n)
    except ValueError:
        return (Grid(_model(sensor), sensor.grid, True, None, bound, None),)
    rows = []
    for at in next(iter(known.values())):
        off = {name: {objects: getattr(of[at], name) for objects, of in known.items()} for name in BOUNDS}
        rows.append(
            Grid(
                _model(sensor, at[1]),
                at[0],
                at == (sensor.grid, sensor.contact),
                {name: max(by_class.values()) for name, by_class in off.items()},
                bound,
                max(of[at].cost_ms for of in known.values()),
                {name: _worst(by_class) for name, by_class in off.items()},
                {name: median(by_class.values()) for name, by_class in off.items()},
            )
        )
    if not any(row.taken for row in rows):
        rows.append(Grid(_model(sensor), sensor.grid, True, None, bound, None))
    return tuple(rows)


def slide_grids(scene: SlipScene) -> tuple[Grid, ...]:
    """The sensor's own model and grid, all that a slip scene can take."""
    sensor = scene.effective_sensor()
    return (Grid(_model(sensor), sensor.grid, True, None, {}, None),)


def slide_warning(scene: SlipScene) -> str:
    """What presses of household objects say about a film on a plate at a slip scene's grid; empty for a hollow skin."""
    sensor = scene.effective_sensor()
    if sensor.support == "hollow":
        return ""
    said = f"a film on a plate at {sensor.grid}x{sensor.grid} is wrong about its surface under points and edges"
    at = (sensor.grid, sensor.contact)
    try:
        known = _by_class(sensor, {row.objects for row in committed_grids().rows}, scene.conditions.loads_n)
        off = {objects: of_class[at].displacement for objects, of_class in known.items()}
    except (ValueError, KeyError):
        return f"{said}; by how much was not measured for this film, grid and load"
    worst = _worst(off)
    return (
        f"{said}: pressed with household objects its displacement is off by up to {off[worst]:.0%} ({worst}; half of "
        f"the classes up to {median(off.values()):.0%})"
    )


def _by_class(sensor: FVSightParameters, classes: Iterable[str], loads_n: Iterable[float]) -> ByClass:
    """Measured choices of each class of objects by (grid, contact); ValueError where something was not measured."""
    parameters, loads = sensor.model_dump(), tuple(loads_n)
    return {
        objects: {(one.grid, one.contact): one for one in measured_choices(parameters, (objects,), loads)}
        for objects in sorted(classes)
    }


def _worst(by_class: dict[str, float]) -> str:
    return max(by_class, key=by_class.__getitem__)


def _model(sensor: FVSightParameters, contact: str | None = None) -> str:
    if (contact or sensor.contact) == "springs":
        return "springs"
    return "skin" if sensor.support == "hollow" else "layer"
