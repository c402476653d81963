"""Train a reduced pad on a coarse mesh, print its errors and its speed: `python -m sensors.contact.neohookean_reduced`.

The full model on the same mesh is the reference, at depths halfway between the trained ones.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from threadpoolctl import threadpool_limits

from sensors.contact.ladder.indenters import INDENTER_CLASSES, indenter
from sensors.contact.ladder.interface import Pad
from sensors.contact.ladder.solid import fitted_mesh
from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean_reduced.measure import Comparison, compare
from sensors.contact.neohookean_reduced.pad import ReducedPad
from sensors.contact.neohookean_reduced.store import save_reduced
from sensors.contact.neohookean_reduced.train import MODES, SAMPLING_TOLERANCE, SNAPSHOTS, train_reduced
from sensors.contact.solver import ConvergenceError

_THICKNESS_M = 2e-3
_MODULUS_PA = 3e5


def main(argv: list[str] | None = None) -> None:
    """Train, compare, print; write the trained pad where asked."""
    options = _parser().parse_args(argv)
    try:
        pad = Pad(LayerMaterial(_THICKNESS_M, _MODULUS_PA, options.poisson), 8 * _THICKNESS_M)
        surface = indenter(options.indenter, _THICKNESS_M)
        with threadpool_limits(1):
            full = NeoHookeanPad(fitted_mesh(pad, surface, options.cells, options.layers), pad.material)
            start = time.perf_counter()
            reduced = train_reduced(
                full,
                surface,
                options.depth * _THICKNESS_M,
                snapshots=options.snapshots,
                modes=options.modes,
                tolerance=options.tolerance,
            )
            trained_s = time.perf_counter() - start
            print("\n".join(_lines(options.indenter, reduced, compare(full, reduced, surface), trained_s)))
        if options.out is not None:
            save_reduced(reduced, options.out)
            print(f"wrote {options.out}")
    except (ValueError, OSError, ConvergenceError) as error:
        raise SystemExit(f"error: {error}") from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m sensors.contact.neohookean_reduced", description=__doc__)
    parser.add_argument("--indenter", default="sphere", help=f"{', '.join(INDENTER_CLASSES)} (default: %(default)s)")
    parser.add_argument("--depth", type=float, default=0.3, help="deepest press over the thickness (default: 0.3)")
    parser.add_argument("--poisson", type=float, default=0.45, help="Poisson's ratio (default: 0.45)")
    parser.add_argument("--cells", type=int, default=12, help="cells from the centre to a side (default: 12)")
    parser.add_argument("--layers", type=int, default=6, help="layers through the thickness (default: 6)")
    parser.add_argument("--snapshots", type=int, default=SNAPSHOTS, help=f"training depths (default: {SNAPSHOTS})")
    parser.add_argument("--modes", type=int, default=MODES, help=f"size of the basis (default: {MODES})")
    parser.add_argument(
        "--tolerance", type=float, default=SAMPLING_TOLERANCE, help="of the element sample; 0 keeps all"
    )
    parser.add_argument("-o", "--out", type=Path, help="write the trained pad to this .npz file")
    return parser


def _lines(name: str, reduced: ReducedPad, result: Comparison, trained_s: float) -> list[str]:
    weights = reduced.solid.weights
    out = [
        f"{name}: {reduced.modes} modes, {int((weights > 0).sum())} of {len(weights)} elements, "
        f"trained in {trained_s:.1f} s on {len(reduced.trained.depths_m) - 1} depths",
        "unseen d/h   full N     reduced N  force %   displacement %",
    ]
    thickness = reduced.material.thickness_m
    columns = (result.depths_m, result.full_n, result.reduced_n, result.force_error, result.displacement_error)
    for depth, full, own, force, shape in zip(*columns, strict=True):
        out.append(f"{depth / thickness:10.4f} {full:10.5f} {own:10.5f} {100 * force:+8.2f} {100 * shape:12.2f}")
    ratio = result.full_ms / result.reduced_ms
    out.append(f"CPU a step: full {result.full_ms:.0f} ms, reduced {result.reduced_ms:.1f} ms ({ratio:.0f} times less)")
    return out


if __name__ == "__main__":
    main()
