"""The registry of household objects: one decorated function is one object."""

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sensors.objects.mesh import Mesh
from sensors.objects.zbuffer import MeshSurface

Array = NDArray[np.float64]
Surface = Callable[[Array, Array], Array]
"""Height in millimetres above the table at points (x, y) in millimetres, any common shape."""


@dataclass(frozen=True)
class HouseholdObject:
    """One object lying on the table, seen from above.

    `size_mm` is (length along x, width along y, height above the table); `centre_mm` is where the middle of
    that box lies in the object's frame, whose origin is put under the middle of the skin. `surface` works in
    millimetres and is zero outside the box; `height` is the same in metres.
    """

    name: str
    title: str
    family: str
    description: str
    size_mm: tuple[float, float, float]
    centre_mm: tuple[float, float]
    surface: Surface

    def height(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Height above the table in metres at points (x, y) in metres; x and y broadcast."""
        x_mm, y_mm = np.broadcast_arrays(1e3 * np.asarray(x, float), 1e3 * np.asarray(y, float))
        return 1e-3 * np.maximum(self.surface(x_mm, y_mm), 0.0)

    def height_map(self) -> NDArray[np.float32]:
        """The default heightfield of this object, metres (see `sensors.objects.heightfield`)."""
        from sensors.objects.raster import heightfield

        return heightfield(self.name)


_OBJECTS: dict[str, HouseholdObject] = {}


def register(
    name: str,
    *,
    title: str,
    family: str,
    description: str,
    size_mm: tuple[float, float, float],
    centre_mm: tuple[float, float] = (0.0, 0.0),
) -> Callable[[Surface], Surface]:
    """Register the decorated height function, millimetres in and out; a taken name is a ValueError."""

    def add(surface: Surface) -> Surface:
        _add(HouseholdObject(name, title, family, description, size_mm, centre_mm, surface))
        return surface

    return add


def register_mesh(
    name: str,
    *,
    title: str,
    family: str,
    description: str,
    size_mm: tuple[float, float, float],
    centre_mm: tuple[float, float] = (0.0, 0.0),
) -> Callable[[Callable[[], Mesh]], Callable[[], Mesh]]:
    """Register the decorated mesh builder, millimetres and table at z = 0; rasterised on first use."""

    def add(build: Callable[[], Mesh]) -> Callable[[], Mesh]:
        surface = MeshSurface(build, size_mm[:2], centre_mm)
        _add(HouseholdObject(name, title, family, description, size_mm, centre_mm, surface))
        return build

    return add


def names() -> tuple[str, ...]:
    """The names of all objects in their fixed order, which is the order of the class labels."""
    return tuple(_loaded())


def get(name: str) -> HouseholdObject:
    """The object called `name`; an unknown name raises a ValueError with the nearest known one."""
    objects = _loaded()
    if name not in objects:
        close = get_close_matches(name, objects, n=1)
        hint = f"did you mean {close[0]!r}?" if close else "`vtbench list objects` shows all of them"
        raise ValueError(f"no household object is called {name!r}; {hint}")
    return objects[name]


def _add(thing: HouseholdObject) -> None:
    if thing.name in _OBJECTS:
        raise ValueError(f"two household objects are called {thing.name!r}; give the second another name")
    _OBJECTS[thing.name] = thing


def _loaded() -> dict[str, HouseholdObject]:
    import_module("sensors.objects.shapes")
    return _OBJECTS
