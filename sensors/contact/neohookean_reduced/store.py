"""A trained pad as one .npz file of plain arrays."""

from __future__ import annotations

import os
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean.material import NeoHookean
from sensors.contact.neohookean.mesh import PadMesh
from sensors.contact.neohookean_reduced.pad import ReducedPad, Trained
from sensors.contact.neohookean_reduced.potential import ReducedSolid

_FORMAT = 1


def save_reduced(pad: ReducedPad, path: Path) -> None:
    """Write a trained pad whole: to a temporary name, then renamed."""
    mesh, material = pad.solid.mesh, pad.material
    arrays = {
        "format": np.array(_FORMAT),
        "nodes": mesh.nodes,
        "elements": mesh.elements,
        "cells": np.array(mesh.cells),
        "quarter": np.array(mesh.quarter),
        "material": np.array([material.thickness_m, material.youngs_modulus_pa, material.poisson_ratio]),
        "basis": pad.solid.basis,
        "weights": pad.solid.weights,
        "contact": np.array([pad.updates, pad.gap_tolerance]),
        **asdict(pad.trained),
    }
    temporary = path.with_name(path.name + ".part")
    with temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def load_reduced(path: Path) -> ReducedPad:
    """Read a trained pad; ValueError in one line where the file is not one."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            arrays = dict(data.items())
        if int(arrays["format"]) != _FORMAT:
            raise ValueError(f"format must be {_FORMAT}, is {arrays['format']}")
        nx, ny, nz = (int(count) for count in arrays["cells"])
        mesh = PadMesh(arrays["nodes"], arrays["elements"], (nx, ny, nz), bool(arrays["quarter"]))
        thickness, modulus, poisson = (float(value) for value in arrays["material"])
        material = LayerMaterial(thickness, modulus, poisson)
        trained = Trained(*(arrays[name] for name in ("depths_m", "forces_n", "amplitudes", "normal_load", "gap")))
        solid = ReducedSolid(mesh, NeoHookean.from_layer(material), arrays["basis"], arrays["weights"])
        updates, gap_tolerance = arrays["contact"]
    except (KeyError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is not a trained reduced pad ({error}); train it anew") from error
    return ReducedPad(solid, material, trained, int(updates), float(gap_tolerance))
