"""Imports torchvision where its compiled operators were built for another torch.

A torchvision built for CUDA beside a torch built for the CPU fails at import, because two operators that it
describes were never defined. Nothing here uses them: defining their schemas lets the import go on. Where
torchvision's own library loads, nothing is touched.
"""

from __future__ import annotations

import importlib
import importlib.util
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from types import ModuleType

SCHEMAS = {
    "torchvision::nms": "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor",
    "torchvision::qnms": "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor",
}


def import_torchvision() -> ModuleType:
    """The torchvision module; ImportError where it is not installed."""
    if not own_library_loads():
        define_missing_schemas()
    return importlib.import_module("torchvision")


def own_library_loads() -> bool:
    """Whether torchvision's compiled operators load into this torch."""
    import torch

    spec = importlib.util.find_spec("torchvision")
    if spec is None:
        raise ImportError("torchvision is not installed; install it.")
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    libraries = [folder / f"_C{suffix}" for folder in folders for suffix in EXTENSION_SUFFIXES]
    for library in libraries:
        if library.exists():
            try:
                torch.ops.load_library(library)  # type: ignore[no-untyped-call]
            except OSError:
                return False
            return True
    return False


def define_missing_schemas() -> None:
    """Define the operators that torchvision describes at import and nobody has defined; no code behind them."""
    import torch

    for name, schema in SCHEMAS.items():
        namespace, operator = name.split("::")
        if not hasattr(getattr(torch.ops, namespace), operator):
            torch.library.define(name, schema)
