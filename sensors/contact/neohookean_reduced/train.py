"""Training: a path of the full model, its modes and the elements that stand for all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensors.contact.neohookean.material import internal_force, strain
from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean.surface import Surface
from sensors.contact.neohookean_reduced.basis import pod_basis
from sensors.contact.neohookean_reduced.pad import ReducedPad, Trained
from sensors.contact.neohookean_reduced.potential import ReducedSolid
from sensors.contact.neohookean_reduced.sampling import sample_elements

Floats = NDArray[np.float64]

SNAPSHOTS = 20
MODES = 16
SAMPLING_TOLERANCE = 1e-3

_GRADING = 1.5
"""Training depths follow t^1.5: a contact grows fastest where it is small."""


def training_depths(deepest_m: float, snapshots: int) -> Floats:
    """Depths (m) of the training path, (snapshots,), the last one `deepest_m`."""
    return deepest_m * (np.arange(1, snapshots + 1) / snapshots) ** _GRADING


def train_reduced(
    pad: NeoHookeanPad,
    surface: Surface,
    deepest_m: float,
    *,
    snapshots: int = SNAPSHOTS,
    modes: int = MODES,
    tolerance: float = SAMPLING_TOLERANCE,
) -> ReducedPad:
    """Press the full `pad` with `surface` along its axis down to `deepest_m` and reduce what it did.

    `tolerance` is that of `sample_elements`; zero keeps every element. Raises what `NeoHookeanPad.press_depths` raises,
    and ValueError for fewer than two snapshots.
    """
    if snapshots < 2 or not deepest_m > 0:
        raise ValueError(
            f"training needs two snapshots or more and a positive depth, got {snapshots} and {deepest_m} m"
        )
    path = list(pad.press_depths(surface, training_depths(deepest_m, snapshots)))
    fields = np.stack([press.displacement.ravel() for press in path])
    basis = pod_basis(fields, modes)
    amplitudes = np.vstack([np.zeros(basis.shape[1]), fields @ basis])
    weights = sample_elements(contributions(pad, basis, amplitudes[1:]), tolerance)
    nothing = np.zeros((1, len(pad.mesh.top)))
    x, y = pad.mesh.nodes[pad.mesh.top, :2].T
    trained = Trained(
        np.array([0.0, *(press.indentation_m for press in path)]),
        np.array([0.0, *(press.force_n for press in path)]),
        amplitudes,
        np.concatenate([nothing, [press.normal_load for press in path]]),
        surface.jet(x, y).gap,
    )
    return ReducedPad(ReducedSolid(pad.mesh, pad.solid, basis, weights), pad.material, trained)


def contributions(pad: NeoHookeanPad, basis: Floats, amplitudes: Floats) -> Floats:
    """Generalised force (N) of each element in each projected snapshot, (snapshots x modes, elements)."""
    mesh = pad.mesh
    modes = basis.reshape(-1, 3, basis.shape[1])[mesh.elements].reshape(len(mesh.elements), 24, -1)
    rows = []
    for amplitude in amplitudes:
        nodal = (modes @ amplitude).reshape(-1, 8, 3)
        local = internal_force(pad.solid, mesh.weights, strain(mesh.gradients, mesh.weights, nodal))
        rows.append(np.einsum("ma,mar->rm", local, modes))
    return np.concatenate(rows)
