"""The harness and the door: datasets, tasks, runs, scores.

The public names of all five packages load from here on first use, so that `import vtbench` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fusion import JKSC as JKSC
    from fusion import KSC as KSC
    from fusion import ErrorEllipsoid as ErrorEllipsoid
    from fusion import GlobalAlignment as GlobalAlignment
    from fusion import WeightedKNN as WeightedKNN
    from fusion import error_ellipsoids as error_ellipsoids
    from fusion import gram_lasso as gram_lasso
    from fusion import kernel_omp_gram as kernel_omp_gram
    from fusion.features import Backbone as Backbone
    from fusion.features import ModalityPCA as ModalityPCA
    from fusion.features import backbone_names as backbone_names
    from fusion.features import get_backbone as get_backbone
    from fusion.neural import FusionTransformer as FusionTransformer
    from fusion.neural import LateFusionNet as LateFusionNet
    from leaderboard import Record as Record
    from leaderboard import build_board as build_board
    from leaderboard import read_records as read_records
    from sensors import PressScene as PressScene
    from sensors import Recording as Recording
    from sensors import simulate as simulate
    from vtbench.config import load_scene as load_scene
    from vtbench.config import load_suite as load_suite
    from vtbench.data import Dataset as Dataset
    from vtbench.data import check_dataset as check_dataset
    from vtbench.data import fetch as fetch
    from vtbench.data import import_folder as import_folder
    from vtbench.data import load_fabricslide16 as load_fabricslide16
    from vtbench.data import write_dataset as write_dataset
    from vtbench.exporting import DetectorOrder as DetectorOrder
    from vtbench.exporting import Order as Order
    from vtbench.exporting import Samples as Samples
    from vtbench.exporting import Trials as Trials
    from vtbench.exporting import export as export
    from vtbench.exporting import export_detector as export_detector
    from vtbench.exporting import open_samples as open_samples
    from vtbench.exporting import open_trials as open_trials
    from vtbench.run import rescore as rescore
    from vtbench.run import run_suite as run_suite

_HOME = {
    "ErrorEllipsoid": "fusion",
    "GlobalAlignment": "fusion",
    "JKSC": "fusion",
    "KSC": "fusion",
    "WeightedKNN": "fusion",
    "error_ellipsoids": "fusion",
    "gram_lasso": "fusion",
    "kernel_omp_gram": "fusion",
    "Backbone": "fusion.features",
    "ModalityPCA": "fusion.features",
    "backbone_names": "fusion.features",
    "get_backbone": "fusion.features",
    "FusionTransformer": "fusion.neural",
    "LateFusionNet": "fusion.neural",
    "Record": "leaderboard",
    "build_board": "leaderboard",
    "read_records": "leaderboard",
    "PressScene": "sensors",
    "Recording": "sensors",
    "simulate": "sensors",
    "load_scene": "vtbench.config",
    "load_suite": "vtbench.config",
    "Dataset": "vtbench.data",
    "check_dataset": "vtbench.data",
    "fetch": "vtbench.data",
    "import_folder": "vtbench.data",
    "load_fabricslide16": "vtbench.data",
    "write_dataset": "vtbench.data",
    "DetectorOrder": "vtbench.exporting",
    "Order": "vtbench.exporting",
    "Samples": "vtbench.exporting",
    "Trials": "vtbench.exporting",
    "export": "vtbench.exporting",
    "export_detector": "vtbench.exporting",
    "open_samples": "vtbench.exporting",
    "open_trials": "vtbench.exporting",
    "rescore": "vtbench.run",
    "run_suite": "vtbench.run",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from vtbench.environment import version

        return version()
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__, "__version__"])
