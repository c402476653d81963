"""The command line: `vtbench COMMAND ...`, errors in one line, exit codes that mean something."""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from argparse import Action, Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

from vtbench.commands import MODULES
from vtbench.commands.parser import Parser
from vtbench.environment import pin_threads
from vtbench.interruption import raise_interruption

OK, PROBLEMS, BAD_INPUT, BUG, INTERRUPTED, NO_READER, TERMINATED = 0, 1, 2, 70, 130, 141, 143

_ABOUT = """\
Simulated and real recordings of vision and touch, classifiers that fuse them, and scores that can be trusted.

From nothing to a table of results:
  vtbench run quick -o out/quick
  vtbench board out/quick -o out/board"""

_CODES = """\
exit codes: 0 done, 1 done but parts of it failed, 2 bad input (one line says which), 70 a bug of vtbench,
130 interrupted, 143 terminated. VTBENCH_DEBUG=1 shows the whole traceback. `vtbench COMMAND --help` shows examples."""


class _Terminated(KeyboardInterrupt):
    """SIGTERM came: what Ctrl-C does, with an exit code of its own."""


class _Version(Action):
    """Prints the version; looked up only when asked for."""

    def __call__(self, parser: Any, namespace: Namespace, values: Any, option_string: str | None = None) -> None:
        from vtbench.environment import version

        print(f"vtbench {version()}")
        parser.exit()


def build_parser() -> Parser:
    """The parser with every command."""
    parser = Parser(prog="vtbench", description=_ABOUT, epilog=_CODES)
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command", parser_class=Parser)
    for module in MODULES:
        module.add(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code."""
    pin_threads()
    debug = os.environ.get("VTBENCH_DEBUG", "") not in ("", "0")
    show_warning = warnings.formatwarning
    resume = ""
    try:
        if not debug:
            warnings.formatwarning = lambda message, *_args, **_named: f"vtbench: warning: {_one_line(message)}\n"
            warnings.filterwarnings("ignore", "A worker stopped while some jobs")  # loky renews one that has grown
        parser = build_parser()
        args = parser.parse_args(sys.argv[1:] if argv is None else list(argv))
        if args.command is None:
            parser.print_help()
            return BAD_INPUT
        resume = args.resume
        with _terminable():
            code = _run(args)
        sys.stdout.flush()
        return code
    except SystemExit as done:  # --help and --version
        return int(done.code or 0)
    except _Terminated:
        return _fail(f"terminated{resume and f'; {resume}'}", TERMINATED, label="")
    except KeyboardInterrupt:
        return _fail(f"interrupted{resume and f'; {resume}'}", INTERRUPTED, label="")
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except (ValueError, OSError) as error:
        if debug:
            raise
        return _fail(_one_line(error), BAD_INPUT)
    except Exception as error:
        if debug:
            raise
        text = f"{type(error).__name__}: {_one_line(error)}"
        return _fail(f"{text} (a bug of vtbench: VTBENCH_DEBUG=1 shows where)", BUG, label="internal error: ")
    finally:
        warnings.formatwarning = show_warning


def _run(args: Namespace) -> int:
    """The command's exit code; code of somebody else that calls `sys.exit` does not decide it."""
    try:
        code: int = args.run(args)
    except SystemError as error:
        raise_interruption(error)
        raise
    except SystemExit as error:
        raise RuntimeError(f"something called sys.exit({error.code!r}) in the middle of the work") from error
    return code


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM (a batch system, `timeout`) end the body like Ctrl-C, so that worker processes end with it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise _Terminated

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _fail(text: str, code: int, label: str = "error: ") -> int:
    print(f"vtbench: {label}{text}", file=sys.stderr)
    return code


def _one_line(error: object) -> str:
    """The message of an exception as one line; the system's own errors begin with their file."""
    if type(error).__name__ == "ValidationError" and hasattr(error, "errors"):
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        return _one_line(f"{where}: {first['msg']}" if where else first["msg"])
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join(str(error).split()) or type(error).__name__


def _drop_output() -> None:
    """Let nothing more be written to a pipe that nobody reads."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
