"""`vtbench check`: would a submission be taken?"""

from __future__ import annotations

import sys
from argparse import Namespace, _SubParsersAction
from pathlib import Path

from vtbench.commands.output import count_text, print_json
from vtbench.commands.parser import Parser, add_command, add_json

BAD_INPUT = 2


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "check",
        run,
        help="check submissions: folders with submission.yaml and a model or predictions, or a model alone",
        about="Lists every problem of every folder by the number of its rule: expected, found, how to fix. Models are\n"
        "looked into in the sandbox, and not run. Exits with 2 when there is a problem.",
        examples=(
            "vtbench check my-submission",
            "vtbench check submissions/* --json",
            "vtbench check net.onnx --task objects/deep/v1",
        ),
    )
    parser.add_argument(
        "folders", metavar="FOLDER", type=Path, nargs="+", help="folders of submissions, or .onnx files"
    )
    parser.add_argument("--task", metavar="TASK", help="of .onnx files: the task that they are for")
    add_json(parser)


def run(args: Namespace) -> int:
    """Check and print; problems go to standard error."""
    from vtbench.submissions.checking import check_folders, check_model
    from vtbench.submissions.rules import RULES

    models = [path for path in args.folders if path.is_file()]
    for path in args.folders:
        if path.suffix == ".onnx" and not path.exists():
            raise ValueError(f"{path}: no such file")
    folders = [path for path in args.folders if path not in models]
    if models and args.task is None:
        raise ValueError(f"--task: say which task {models[0]} solves (`vtbench list tasks`)")
    if args.task is not None and folders:
        raise ValueError(f"--task: it is for .onnx files; the submission.yaml of {folders[0]} says its tasks")
    checked = [*check_folders(folders), *(check_model(path, args.task) for path in models)]
    if args.json:
        print_json(
            [
                {
                    "folder": each.folder,
                    "ok": not each.problems,
                    "id": each.file.id if each.file else None,
                    "problems": [
                        {"rule": p.rule, "states": RULES[p.rule], "entry": p.entry, "found": p.found, "fix": p.fix}
                        for p in each.problems
                    ],
                }
                for each in checked
            ]
        )
    else:
        for each in checked:
            for problem in each.problems:
                print(f"vtbench: error: {each.folder}: {problem}", file=sys.stderr)
            if each.file is not None and not each.problems:
                entries = len(each.file.entries)
                noun = "entry" if entries == 1 else "entries"
                print(f"{each.folder}: ok ({each.file.id}, {entries} {noun})")
            elif not each.problems:
                print(f"{each.folder}: ok (model for {args.task})")
        bad = sum(bool(each.problems) for each in checked)
        if bad:
            print(f"{count_text(len(checked), 'submission')}: {bad} with problems", file=sys.stderr)
    return BAD_INPUT if any(each.problems for each in checked) else 0
