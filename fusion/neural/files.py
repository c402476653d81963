"""A learnt net on disk: one .npz of plain arrays and a header in JSON, written whole or not at all; no pickle."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.neural.layout import FloatArray
from fusion.neural.scaling import Scale

FORMAT = "fusion net 1"


@dataclass(frozen=True, eq=False)
class KeptNet:
    """What a fitted net is made of.

    Attributes:
        kind: the estimator's class.
        params: its parameters.
        scales: modality -> scale; weights: name -> array.
    """

    kind: str
    params: Mapping[str, Any]
    n_features: int
    n_epochs: int
    scales: Mapping[str, Scale]
    weights: Mapping[str, FloatArray]
    classes: NDArray[Any]
    validation_loss: FloatArray


def write_net(path: Path, kept: KeptNet) -> Path:
    """Write a net; ValueError for labels that are neither numbers nor text, and for modalities not named by text."""
    classes = kept.classes
    if classes.dtype == object and all(isinstance(label, str) for label in classes):
        classes = classes.astype(np.str_)
    if classes.dtype.kind not in "biufU":
        raise ValueError(f"labels must be numbers or text to be saved, got {classes.dtype}.")
    odd = [name for name in kept.scales if not isinstance(name, str)]
    if odd:
        raise ValueError(f"modalities must have names of text to be saved, got {odd[0]!r}.")
    header = {
        "format": FORMAT,
        "kind": kept.kind,
        "params": {name: _plain(value) for name, value in kept.params.items()},
        "n_features": kept.n_features,
        "n_epochs": kept.n_epochs,
    }
    arrays: dict[str, NDArray[Any]] = {"classes": classes, "validation_loss": kept.validation_loss}
    for name, scale in kept.scales.items():
        arrays |= {f"mean/{name}": scale.mean, f"spread/{name}": scale.spread}
    arrays |= {f"weight/{name}": values for name, values in kept.weights.items()}
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("wb") as file:
            np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)  # type: ignore[arg-type]
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def read_net(path: Path) -> KeptNet:
    """The net of a file; ValueError for another file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            if header.get("format") != FORMAT:
                raise ValueError(f"its format is {header.get('format')!r}, expected {FORMAT!r}")
            named = {kind: _named(file, kind) for kind in ("mean", "spread", "weight")}
            params = header["params"]
            if params["modalities"] is not None:
                params["modalities"] = {name: np.array(each) for name, each in params["modalities"].items()}
            return KeptNet(
                header["kind"],
                params,
                int(header["n_features"]),
                int(header["n_epochs"]),
                {name: Scale(mean, named["spread"][name]) for name, mean in named["mean"].items()},
                named["weight"],
                file["classes"],
                file["validation_loss"],
            )
    except (KeyError, TypeError, AttributeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is no saved fusion net: {error}") from None


def _named(file: Any, kind: str) -> dict[str, FloatArray]:
    """Arrays of one kind by name."""
    return {name.partition("/")[2]: file[name] for name in file.files if name.startswith(f"{kind}/")}


def _plain(value: Any) -> Any:
    """A parameter as JSON."""
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.random.RandomState):
        raise ValueError("random_state must be a number or None for the net to be saved.")
    return list(value) if isinstance(value, tuple) else value
