"""Datasets on disk: format, writer, reader, importers, public recordings."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vtbench.data.checks import check_dataset as check_dataset
    from vtbench.data.folder_import import import_folder as import_folder
    from vtbench.data.meta import DatasetMeta as DatasetMeta
    from vtbench.data.reader import Dataset as Dataset
    from vtbench.data.writer import write_dataset as write_dataset

_HOMES = {
    "Dataset": "reader",
    "DatasetMeta": "meta",
    "check_dataset": "checks",
    "import_folder": "folder_import",
    "write_dataset": "writer",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f"vtbench.data.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
