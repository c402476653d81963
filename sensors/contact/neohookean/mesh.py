"""Hexahedral meshes: any eight-node mesh, and the graded brick mesh of a pad."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
"""Corners of the parent cube in the order of an element's nodes, (8, 3)."""

_GAUSS = CORNERS / np.sqrt(3)


@dataclass(frozen=True)
class HexMesh:
    """Nodes (n, 3) in metres and elements (m, 8), each listed in the order of `CORNERS`."""

    nodes: Floats
    elements: Indices

    def __post_init__(self) -> None:
        if (self.weights <= 0).any():
            raise ValueError("a hexahedron of the mesh is inverted or listed in the wrong order")

    @cached_property
    def _gradients_and_weights(self) -> tuple[Floats, Floats]:
        parent = _parent_gradients()
        jacobian = np.einsum("qar,maj->mqjr", parent, self.nodes[self.elements])
        gradients = np.einsum("qar,mqrj->mqaj", parent, np.linalg.inv(jacobian))
        return np.ascontiguousarray(gradients), np.linalg.det(jacobian)

    @property
    def gradients(self) -> Floats:
        """Derivatives (1/m) of the eight shape functions at the eight Gauss points, (m, 8, 8, 3)."""
        return self._gradients_and_weights[0]

    @property
    def weights(self) -> Floats:
        """Volume (m^3) that each Gauss point stands for, (m, 8)."""
        return self._gradients_and_weights[1]


def _parent_gradients() -> Floats:
    """d N_a / d xi_r at the Gauss points of the parent cube, (8, 8, 3)."""
    factors = 1 + CORNERS[None, :, :] * _GAUSS[:, None, :]
    out = np.empty((8, 8, 3))
    for r in range(3):
        others = [s for s in range(3) if s != r]
        out[:, :, r] = CORNERS[:, r] * factors[:, :, others[0]] * factors[:, :, others[1]] / 8
    return out


@dataclass(frozen=True)
class PadMesh(HexMesh):
    """A brick of (nx, ny, nz) cells; node (ix, iy, iz) has index (ix (ny + 1) + iy) (nz + 1) + iz, base at z = 0.

    A `quarter` mesh is the part x, y >= 0 of a pad that x -> -x and y -> -y leave alike.
    """

    cells: tuple[int, int, int]
    quarter: bool = False

    @property
    def points(self) -> tuple[int, int, int]:
        """Nodes along x, y and z."""
        nx, ny, nz = self.cells
        return nx + 1, ny + 1, nz + 1

    @property
    def copies(self) -> int:
        """How many times the mesh stands in the whole pad."""
        return 4 if self.quarter else 1

    @cached_property
    def top(self) -> Indices:
        """Nodes of the touched face, (n_top,)."""
        return self._layer(-1)

    @cached_property
    def base(self) -> Indices:
        """Nodes of the bonded face, (n_top,)."""
        return self._layer(0)

    def _layer(self, iz: int) -> Indices:
        return np.arange(len(self.nodes)).reshape(self.points)[:, :, iz].ravel()

    @cached_property
    def top_area(self) -> Floats:
        """Area (m^2) that belongs to each node of `top`, (n_top,)."""
        lattice = self.nodes.reshape(*self.points, 3)
        return np.outer(_shares(lattice[:, 0, 0, 0]), _shares(lattice[0, :, 0, 1])).ravel()

    def fixed(self) -> NDArray[np.bool_]:
        """Degrees of freedom (n, 3) held at zero: the base, and the normals of the planes of symmetry."""
        held = np.zeros_like(self.nodes, dtype=bool)
        held[self.base] = True
        if self.quarter:
            held[:, :2] |= self.nodes[:, :2] == 0
        return held


def _shares(line: Floats) -> Floats:
    steps = np.diff(line) / 2
    return np.concatenate([steps, [0]]) + np.concatenate([[0], steps])


def brick(x: Floats, y: Floats, z: Floats, *, quarter: bool = False) -> PadMesh:
    """A brick mesh over three increasing lines of coordinates (m)."""
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(nodes)).reshape(len(x), len(y), len(z))
    corner = (CORNERS > 0).astype(int)
    cells = (len(x) - 1, len(y) - 1, len(z) - 1)
    columns = [index[i : i + cells[0], j : j + cells[1], k : k + cells[2]].ravel() for i, j, k in corner]
    return PadMesh(nodes, np.stack(columns, axis=1), cells, quarter)


def graded_pad(
    side_m: float,
    thickness_m: float,
    core_m: tuple[float, float],
    cells: int,
    layers: int,
    *,
    quarter: bool = False,
) -> PadMesh:
    """A square pad whose cells are fine within about `core_m` / 2 of the centre, along x and y, and below the top.

    `cells` counts from the centre to a side, `layers` through the thickness. Lines follow x = core t + (side/2 - core)
    t^5 and depth = h (0.6 t + 0.4 t^2), so that meshes of different counts refine each other evenly.
    """
    half = side_m / 2
    if not all(0 < core <= half for core in core_m) or thickness_m <= 0 or cells < 2 or layers < 1:
        raise ValueError(
            "a pad mesh needs 0 < core_m <= side_m / 2, a positive thickness, cells >= 2 and layers >= 1, got "
            f"core_m={core_m}, side_m={side_m}, thickness_m={thickness_m}, cells={cells}, layers={layers}"
        )
    lines = []
    for core in core_m:
        t = np.linspace(0, 1, cells + 1)
        line = core * t + (half - core) * t**5
        lines.append(line if quarter else np.concatenate([-line[:0:-1], line]))
    t = np.linspace(1, 0, layers + 1)
    return brick(lines[0], lines[1], thickness_m * (1 - 0.6 * t - 0.4 * t**2), quarter=quarter)
