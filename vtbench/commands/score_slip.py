"""`vtbench score-slip`: every slip detector on a folder of one's own sequences."""

from __future__ import annotations

from argparse import ArgumentTypeError, Namespace, _SubParsersAction
from pathlib import Path

from vtbench.commands.output import print_json
from vtbench.commands.parser import Parser, add_command, add_json, one_of, some_of, whole_number

_ABOUT = """\
The folder holds LABEL/NAME.csv, one sequence a file, one line a sample, columns = taxels, heading optional:
  slip/mug_01.csv      a sequence that holds a slip
  tapping/mug_02.csv   any other label: no slip, a kind of disturbance; rest/ also tells the noise
The object is the file's name without its number (mug_01.csv: mug); thresholds come from the other objects.
With a heading, a column `slip` (0 or 1 a sample) tells when the object slips: only then are there delays."""

_PROBLEMS = 1


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "score-slip",
        run,
        help="score every slip detector on your own sequences",
        about=_ABOUT,
        examples=(
            "vtbench score-slip recordings --rate-hz 1000",
            "vtbench score-slip recordings --rate-hz 100 --window 20 --detectors covariance,energy",
            "vtbench score-slip recordings --rate-hz 1000 -o out/mine && vtbench board out/mine -o out/board",
        ),
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="the sequences, as LABEL/NAME.csv")
    parser.add_argument("--rate-hz", metavar="R", type=_rate, required=True, help="samples a second")
    parser.add_argument("--window", metavar="N", type=whole_number(2), default=50, help="of the detectors, in samples")
    parser.add_argument("--detectors", metavar="NAMES", type=_detectors, default=(), help="some of `list detectors`")
    parser.add_argument(
        "--leave-out",
        metavar="WHAT",
        type=one_of("part", ("object", "sequence")),
        default="object",
        help="thresholds from all other objects (default) or from all other sequences",
    )
    parser.add_argument("-o", "--out", metavar="DIR", type=Path, help="also keep the records, for `vtbench board`")
    add_json(parser)


def run(args: Namespace) -> int:
    """Score and print the tables."""
    from leaderboard.console import format_console
    from leaderboard.contents import board_tables
    from leaderboard.record import write_record
    from vtbench.data.files import make_folder
    from vtbench.data.slip_folder import read_slip_folder
    from vtbench.run.detection.own import score_own, sequence_data
    from vtbench.run.provenance import provenance

    sequences = read_slip_folder(args.folder, args.rate_hz)
    data = sequence_data(sequences, args.rate_hz)
    records = []
    for record in score_own(
        data,
        args.folder.resolve().name,
        provenance(),
        detectors=args.detectors,
        leave_out=args.leave_out,
        window=args.window,
    ):
        records.append(record)
        if args.out is not None:
            make_folder(args.out)
            write_record(args.out, record)
    code = _PROBLEMS if any(record.status.state in ("failed", "timeout") for record in records) else 0
    if args.json:
        print_json([record.model_dump(mode="json", exclude={"provenance"}) for record in records])
        return code
    seconds = sum(len(sequence.force) for sequence in sequences) / args.rate_hz
    with_slip = sum(sequence.has_slip for sequence in sequences)
    objects = len({sequence.object for sequence in sequences})
    print(
        f"{args.folder}: {len(sequences)} sequences ({with_slip} with slip) of {objects} objects, "
        f"{sequences[0].force.shape[1]} taxels, {seconds / 60:.1f} min\n"
    )
    print(format_console(board_tables(records)))
    if not data.onsets_known:
        print("No delays: they need a column 'slip' that says when each sequence slips.")
    return code


def _rate(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e7:
        raise ArgumentTypeError(f"expected samples a second, such as 1000, got {text!r}")
    return value


def _detectors(text: str) -> tuple[str, ...]:
    from vtbench.run.detection.methods import DETECTORS

    return some_of("detector", DETECTORS.ids())(text)
