"""Datasets on disk: format, writer, reader, importers, public recordings."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vtbench.data.biotacsp_stability_v2 import load_biotacsp_stability_v2 as load_biotacsp_stability_v2
    from vtbench.data.checks import check_dataset as check_dataset
    from vtbench.data.fabricslide16 import FabricSlide16 as FabricSlide16
    from vtbench.data.fabricslide16 import load_fabricslide16 as load_fabricslide16
    from vtbench.data.fetching import fetch as fetch
    from vtbench.data.folder_import import import_folder as import_folder
    from vtbench.data.gelsight_ball_presses import load_gelsight_ball_presses as load_gelsight_ball_presses
    from vtbench.data.meta import DatasetMeta as DatasetMeta
    from vtbench.data.public import PublicSet as PublicSet
    from vtbench.data.public import data_root as data_root
    from vtbench.data.public import public_set as public_set
    from vtbench.data.reader import Dataset as Dataset
    from vtbench.data.slide_reader import SlideDataset as SlideDataset
    from vtbench.data.slide_writer import write_slides as write_slides
    from vtbench.data.writer import write_dataset as write_dataset

_HOMES = {
    "Dataset": "reader",
    "DatasetMeta": "meta",
    "FabricSlide16": "fabricslide16",
    "PublicSet": "public",
    "SlideDataset": "slide_reader",
    "check_dataset": "checks",
    "data_root": "public",
    "fetch": "fetching",
    "import_folder": "folder_import",
    "load_biotacsp_stability_v2": "biotacsp_stability_v2",
    "load_fabricslide16": "fabricslide16",
    "load_gelsight_ball_presses": "gelsight_ball_presses",
    "public_set": "public",
    "write_dataset": "writer",
    "write_slides": "slide_writer",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f"vtbench.data.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
