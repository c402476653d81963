"""`vtbench physics`: error against speed of every contact model."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, picture

if TYPE_CHECKING:
    from sensors.contact.ladder import LadderTable
    from sensors.contact.scoring import OracleRow, PeerRow, SolidRow

_LAYERS = ("layer-64", "layer-128", "layer-fine")
_WANTED, _DEEP = 0.02, 0.2


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "physics",
        run,
        help="score the contact models: error against speed",
        about="The rungs of the contact ladder against the hyperelastic pad (from the committed table; --neohookean "
        "measures it\nagain, twenty minutes), every model against closed forms with its cold and warm CPU time on one "
        "thread, and the\nhalf-space beside tamaas at equal error of the pressure, where that is installed "
        "(extra `peers`).",
        examples=("vtbench physics", "vtbench physics -o out/physics.png", "vtbench physics --json"),
    )
    parser.add_argument("-o", "--out", metavar="FILE.png", type=picture, help="draw the figure too")
    parser.add_argument("--neohookean", action="store_true", help="measure the ladder's table again, and print that")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure, draw, print."""
    from threadpoolctl import threadpool_limits

    from sensors.contact.ladder import committed_table, measure_ladder
    from sensors.contact.scoring import against_hyperelastic, compare_with_tamaas, score_closed_forms
    from sensors.contact.scoring.peer import has_tamaas
    from vtbench.run.progress import bar

    grids = (64, 128, 256)
    with threadpool_limits(1), bar(2 * len(grids), "contact models", not args.json) as advance:
        table = measure_ladder() if args.neohookean else committed_table()
        solid = against_hyperelastic(table=table)
        oracles: list[OracleRow] = []
        peers: list[PeerRow] = []
        for n in grids:
            oracles += score_closed_forms((n,))
            advance(1)
        for n in grids:
            peers += compare_with_tamaas((n,)) if has_tamaas() else []
            advance(1)
    oracles.sort(key=lambda row: (row.model, row.oracle, row.precision, row.grid))
    if args.out:
        _draw(args.out, table, solid, oracles, peers)
    if args.json:
        _print_json(args.out, table, solid, oracles, peers)
    else:
        _print(table, solid, oracles, peers)
        if args.out:
            print(f"\n{args.out}")
    return 0


def _draw(out: Path, table: LadderTable, solid: list[SolidRow], oracles: list[OracleRow], peers: list[PeerRow]) -> None:
    from sensors.contact.scoring.figure import draw_physics
    from vtbench.data.files import make_folder, write_whole

    deepest = sum(depth <= _DEEP for depth in table.depth_ratios)
    make_folder(out.parent)
    write_whole(out, lambda png: draw_physics(png, solid, oracles, peers, deepest))


def _print_json(
    out: Path | None, table: LadderTable, solid: list[SolidRow], oracles: list[OracleRow], peers: list[PeerRow]
) -> None:
    from vtbench.environment import fingerprint, machine

    rows: dict[str, Sequence[Any]] = {"against_hyperelastic": solid, "closed_forms": oracles, "tamaas": peers}
    print_json(
        {
            "machine": machine(),
            "fingerprint": fingerprint(),
            "threads": 1,
            "depth_ratios": table.depth_ratios,
            "reference": table.reference,
            "table_machine": table.machine,
            **{name: [asdict(row) for row in found] for name, found in rows.items()},
            "picture": out,
        }
    )


def _print(table: LadderTable, solid: list[SolidRow], oracles: list[OracleRow], peers: list[PeerRow]) -> None:
    from sensors.contact.scoring.hyperelastic import force_within

    depths = [f"{depth:g}" for depth in table.depth_ratios]
    print(f"AGAINST THE HYPERELASTIC PAD: {table.reference}; worst of all pads, force error % at d/h")
    print_table(
        ["rung", "indenter", *depths, "displacement %", "reference's own %", "ms CPU"],
        [
            [row.rung, row.indenter, *(f"{100 * one:+.2f}" for one in row.force), 100 * max(row.displacement),
             100 * max(row.reference), row.cost_ms]
            for row in solid
        ],
    )  # fmt: skip
    for rung in _LAYERS:
        worst, within = force_within(_WANTED, _DEEP, rung, table)
        named = ", ".join(within) or "no class"
        print(
            f"{rung}, pads 8 thicknesses wide, d/h to {_DEEP:g}: up to {worst:.1%} off; within {_WANTED:.0%}: {named}"
        )
    print("\nAGAINST CLOSED FORMS, at the solver's usual tolerance")
    print_table(
        ["model", "cells", "precision", "oracle", "error", "ms cold", "ms warm"],
        [[r.model, r.grid, r.precision, r.oracle, f"{r.error:.2e}", r.cold_ms, r.warm_ms] for r in oracles],
    )
    print("\nBESIDE TAMAAS: half-space under a sphere, non-periodic, float64, cold, one thread each")
    if not peers:
        print("not installed: pip install 'vtbench[peers]'")
        return
    print_table(
        ["cells", "pressure error", "tamaas' error", "ms", "tamaas ms", "times faster", "5 to 95 %"],
        [[p.grid, f"{p.error:.3%}", f"{p.peer_error:.3%}", p.ours_ms, p.peer_ms, p.ratio,
          f"{p.ratio_low:.1f} to {p.ratio_high:.1f}"] for p in peers],
    )  # fmt: skip
