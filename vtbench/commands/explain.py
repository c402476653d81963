"""`vtbench explain`: what each effect of a scene costs, and the error that leaving it out causes."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from dataclasses import asdict
from typing import TYPE_CHECKING

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, whole_number

if TYPE_CHECKING:
    from sensors.explain import Effect, Explanation, Grid


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "explain",
        run,
        help="show what each effect of a scene costs, and the error that leaving it out causes",
        about="Every effect is switched, on to off or off to on, on a few samples of the scene: `time` is its share of "
        "the CPU time\n(what an effect that is off would add; a few percent either way are noise), `force N` the RMS "
        "over time of the taxel\nthat changes most, `frame` the RMS over the frame in grey levels, `surface um` the "
        "largest change of the surface that\nthe camera sees. Below stand the stages of a sample and the contact "
        "models and grids with their measured errors; a\nscene's `error_bound` (force, displacement, frame) takes the "
        "cheapest that is within.",
        examples=(
            "vtbench explain fvsight-press",
            "vtbench explain fvsight-press/hard --samples 8",
            "vtbench explain fvsight-slip/hard --json",
        ),
    )
    parser.add_argument("scene", metavar="SCENE", help="name (`vtbench list scenes`) or a YAML file of your own")
    parser.add_argument("--samples", metavar="N", type=whole_number(1), help="to measure on (default 4; slides 1)")
    parser.add_argument("--seed", metavar="S", type=whole_number(0), default=0, help="run seed (default 0)")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from threadpoolctl import threadpool_limits

    from sensors.scene import PressScene
    from vtbench.config import load_scene
    from vtbench.run.progress import bar

    scene = load_scene(args.scene)
    asked = {} if args.samples is None else {"samples": args.samples}
    with threadpool_limits(1):
        if isinstance(scene, PressScene):
            from sensors.explain_press import explain_press, n_effects

            with bar(n_effects(scene), "effects", not args.json) as advance:
                found = explain_press(scene, seed=args.seed, advance=advance, **asked)
        else:
            from sensors.explain_slide import explain_slide, n_slide_effects

            with bar(n_slide_effects(), "effects", not args.json) as advance:
                found = explain_slide(scene, seed=args.seed, advance=advance, **asked)
    if args.json:
        print_json(asdict(found))
        return 0
    _print(found)
    return 0


def _print(found: Explanation) -> None:
    counted = "1 sample" if found.samples == 1 else f"{found.samples} samples"
    print(f"{found.scene}: {found.cpu_ms:.1f} ms CPU a sample, measured on {counted}\n")
    print_table(["effect", "is", "time", "force N", "frame", "surface um", "why"], list(map(_effect, found.effects)))
    if found.stages_ms:
        whole = found.stages_ms["frame total"] + found.stages_ms["force history"]
        print()
        print_table(["stage", "ms CPU", "share"], [[k, v, f"{v / whole:.0%}"] for k, v in found.stages_ms.items()])
    print()
    print_table(["contact", "is", "force", "displacement", "frame", "ms CPU", "bound"], list(map(_grid, found.grids)))
    if said := _whose(found):
        print(said)
    if found.models:
        print(found.models)


def _whose(found: Explanation) -> str:
    """Which class of objects the errors of the contact taken are, and what half of the classes keep to."""
    taken = next((row for row in found.grids if row.taken and row.worst), None)
    if taken is None:
        return ""
    parts = []
    for name, error in (taken.error or {}).items():
        form = "{:.3f}" if name == "frame" else "{:.2%}"
        middle = form.format(taken.median[name])
        parts.append(f"{name} {form.format(error)} of {taken.worst[name]} (median class {middle})")
    return f"errors are those of the worst class of objects; taken: {', '.join(parts)}"


def _effect(row: Effect) -> list[object]:
    share = None if row.time_share is None else f"{'' if row.on else '+'}{row.time_share:.1%}".replace("+-", "-")
    errors = [
        f"{value:.3g}" if value is not None else None for value in (row.force_n, row.frame_levels, row.surface_um)
    ]
    return [row.name, "on" if row.on else "off", share, *errors, row.why]


def _grid(row: Grid) -> list[object]:
    error = row.error or {}
    shown = [f"{error[name]:.2%}" if name in error else None for name in ("force", "displacement")]
    bound = ", ".join(f"{name} {value:g}" for name, value in row.bound.items()) or None
    frame = f"{error['frame']:.3f}" if "frame" in error else None
    return [f"{row.model} {row.grid}x{row.grid}", "taken" if row.taken else "", *shown, frame, row.cost_ms, bound]
