"""Twenty-seven household objects as heightfields: what a soft skin pressed down on a table would meet."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sensors.objects.gallery import draw_gallery, draw_object
    from sensors.objects.household import HouseholdObject, get, names
    from sensors.objects.raster import heightfield, place
    from sensors.objects.similarity import nearest_pairs

__all__ = [
    "HouseholdObject",
    "draw_gallery",
    "draw_object",
    "get",
    "heightfield",
    "names",
    "nearest_pairs",
    "place",
]

_HOME = {
    "HouseholdObject": "household",
    "draw_gallery": "gallery",
    "draw_object": "gallery",
    "get": "household",
    "heightfield": "raster",
    "names": "household",
    "nearest_pairs": "similarity",
    "place": "raster",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
