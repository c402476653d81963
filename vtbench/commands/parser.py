"""Argument parsing whose errors are one line, with a close match for a misspelt command, option or word."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from vtbench.registry import hint


class UsageError(ValueError):
    """A command line that cannot be followed; the message is the whole line to print."""


class Parser(argparse.ArgumentParser):
    """`ArgumentParser` that raises `UsageError` instead of printing its usage, and never guesses abbreviations."""

    def __init__(self, **settings: Any) -> None:
        settings.setdefault("allow_abbrev", False)
        settings.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(**settings)

    def error(self, message: str) -> NoReturn:
        """Raise `UsageError` with argparse's message and where help is."""
        raise UsageError(f"{message} (`{self.prog} --help`)")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As `ArgumentParser`, but misspelt words are reported before missing ones."""
        self._check_words(args)
        return super().parse_known_args(args, namespace)

    def _check_words(self, words: Sequence[str]) -> None:
        commands = next((a.choices for a in self._actions if isinstance(a, argparse._SubParsersAction)), None)
        for word in words:
            if word == "--":
                return
            if self._is_option(word):
                name = word.partition("=")[0]
                known = name in self._option_string_actions or (
                    name[1] != "-" and name[:2] in self._option_string_actions
                )
                if not known:
                    options = [option for option in self._option_string_actions if option.startswith("--")]
                    self.error(f"unknown option {name!r}{hint(name, options)}")
            elif commands is not None:
                if word not in commands:
                    self.error(f"unknown command {word!r}{hint(word, commands)}")
                return

    def _is_option(self, word: str) -> bool:
        return len(word) > 1 and word[0] == "-" and not self._negative_number_matcher.match(word)


def whole_number(minimum: int) -> Callable[[str], int]:
    """An argument type: a whole number of at least `minimum`."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = minimum - 1
        if value < minimum:
            raise argparse.ArgumentTypeError(f"expected a whole number of at least {minimum}, got {text!r}")
        return value

    return parse


def one_of(kind: str, choices: Sequence[str]) -> Callable[[str], str]:
    """An argument type: one of a few words."""

    def parse(text: str) -> str:
        if text not in choices:
            raise argparse.ArgumentTypeError(f"unknown {kind} {text!r}{hint(text, choices)}")
        return text

    return parse


def some_of(kind: str, choices: Sequence[str]) -> Callable[[str], tuple[str, ...]]:
    """An argument type: words joined by commas, each one of `choices`; kept in the order of `choices`."""
    one = one_of(kind, choices)

    def parse(text: str) -> tuple[str, ...]:
        asked = {one(word.strip()) for word in text.split(",") if word.strip()}
        return tuple(choice for choice in choices if choice in asked)

    return parse


def folder(text: str) -> Path:
    """An argument type: a folder to write; an empty word (a variable that is not set) is not the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"expected a folder, got {text!r}; the current one is '.'")
    return Path(text)


def picture(text: str) -> Path:
    """An argument type: a `.png` file to write."""
    path = Path(text)
    if path.suffix.lower() != ".png":
        raise argparse.ArgumentTypeError(f"expected a file that ends in .png, got {text!r}")
    return path


def add_command(
    commands: argparse._SubParsersAction[Parser],
    name: str,
    run: Callable[[argparse.Namespace], int],
    *,
    help: str,
    examples: Sequence[str],
    about: str = "",
    resume: str = "nothing was left half done",
) -> Parser:
    """Add a command.

    Args:
        commands: the door's subcommands.
        name: the verb.
        run: does the work and returns the exit code.
        help: one line for the list of commands.
        examples: command lines for its help.
        about: further paragraphs for its help.
        resume: what an interrupted user is told.
    """
    parser = commands.add_parser(
        name,
        help=help,
        description=f"{help[0].upper()}{help[1:]}." + (f"\n\n{about}" if about else ""),
        epilog="examples:\n" + "\n".join(f"  {example}" for example in examples),
    )
    parser.set_defaults(run=run, resume=resume)
    return parser


def add_json(parser: Parser) -> None:
    """Give a command `--json`."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def add_out(
    parser: Parser, metavar: str, help: str, type: Callable[[str], Any] = folder, *, required: bool = True
) -> None:
    """Give a command its `-o`."""
    parser.add_argument("-o", "--out", metavar=metavar, type=type, required=required, help=help)


def add_scheduler(parser: Parser) -> None:
    """Give a command `--scheduler`."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="workers of a Dask scheduler instead: tcp://HOST:PORT",
    )


def add_jobs(parser: Parser) -> None:
    """Give a command `--jobs`."""
    parser.add_argument(
        "--jobs", "-j", metavar="J", type=whole_number(1), default=1, help="processes to work with (default 1)"
    )
