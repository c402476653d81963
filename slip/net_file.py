"""A trained net on disk: one .npz of plain arrays and a header in JSON, written whole or not at all; no pickle."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from slip.net import Net, NetShape
from slip.samples import Floats

FORMAT = "slip net 1"


def write_net(path: Path, net: Net, scale: Floats, header: Mapping[str, Any]) -> Path:
    """Write a net with the scale of its differences and what else a detector needs (`header`, JSON)."""
    text = json.dumps({**header, "format": FORMAT, "shape": asdict(net.shape), "frame_scale": net.frame_scale})
    arrays = {f"net.{name}": values.astype(np.float32) for name, values in net.weights.items()}
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("wb") as file:
            np.savez(file, header=np.array(text), scale=scale, **arrays)  # type: ignore[arg-type]
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def read_net(path: Path) -> tuple[Net, Floats, dict[str, Any]]:
    """Return the net, the scale (taxels,) and the header. Raises OSError, or ValueError for another file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            if header.get("format") != FORMAT:
                raise ValueError(f"its format is {header.get('format')!r}, expected {FORMAT!r}")
            shape = NetShape(**header["shape"])
            weights = {name: file[f"net.{name}"].astype(np.float64) for name in shape.weights()}
            scale = file["scale"].astype(np.float64)
            return Net(shape, weights, float(header["frame_scale"])), scale, header
    except (KeyError, TypeError, AttributeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is no trained slip net: {error}") from None
