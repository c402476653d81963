"""Somebody's own scikit-learn classifier, by import path: `my_pkg.my_mod:MyClassifier`."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from vtbench.registry import hint
from vtbench.run.methods.base import Classifier, Groups, Method, Params

_PATH = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")


def external_method(method_id: str, estimator: str, params: Params, choices: Mapping[str, tuple[Any, ...]]) -> Method:
    """A method from an import path; the checksum of its module becomes part of its records' keys.

    Args:
        method_id: as suites and tables name it.
        estimator: `package.module:Class`; the current folder is searched too.
        params: arguments of the class.
        choices: arguments whose values are chosen on training folds.

    Raises:
        ValueError: no such module, in one line.
    """
    return Method(
        method_id,
        estimator,
        partial(_build, estimator, dict(params)),
        choices,
        source={"estimator": estimator, "params": dict(params), "sha256": _checksum(estimator)},
    )


def check_external(method: Method) -> None:
    """Build the classifier once.

    Raises:
        ValueError: the module fails to import, has no such class, or the class is not a classifier or refuses
            its arguments; one line.
    """
    first = {name: values[0] for name, values in method.choices.items()}
    method.build({}, {}, first)


def _build(estimator: str, fixed: Params, groups: Groups, weights: Mapping[str, float], params: Params) -> Classifier:
    cls = _load(estimator)
    try:
        made: Classifier = cls(**{**fixed, **params})
    except Exception as error:
        raise ValueError(f"{estimator}: cannot be made with { ({**fixed, **params}) }: {error}") from error
    for need in ("fit", "predict"):
        if not callable(getattr(made, need, None)):
            raise ValueError(f"{estimator} is not an estimator: it has no {need}()")
    return made


def _load(estimator: str) -> Any:
    module_name, _, name = estimator.partition(":")
    with _current_folder_importable():
        try:
            module = importlib.import_module(module_name)
        except ModuleNotFoundError as error:
            raise ValueError(f"{estimator}: {error}; run from the folder that holds it, or install it") from error
        except Exception as error:
            raise ValueError(f"{estimator}: importing {module_name} fails: {type(error).__name__}: {error}") from error
    if not hasattr(module, name):
        names = [word for word, value in vars(module).items() if isinstance(value, type)]
        raise ValueError(f"{estimator}: module {module_name} has no class {name!r}{hint(name, names)}")
    cls = getattr(module, name)
    if not isinstance(cls, type):
        raise ValueError(f"{estimator} is a {type(cls).__name__}, expected a class with fit() and predict()")
    return cls


def _checksum(estimator: str) -> str:
    """SHA-256 of the module's file; of nothing where it has none."""
    if not _PATH.fullmatch(estimator):
        raise ValueError(f"estimator {estimator!r}: expected 'package.module:Class'")
    module_name = estimator.partition(":")[0]
    with _current_folder_importable():
        try:
            spec = importlib.util.find_spec(module_name)
        except ModuleNotFoundError:
            spec = None
        except Exception as error:
            raise ValueError(f"{estimator}: looking for {module_name} fails: {error}") from error
    if spec is None:
        raise ValueError(f"{estimator}: no module {module_name!r}; run from the folder that holds it, or install it")
    origin = Path(spec.origin) if spec.origin else None
    return hashlib.sha256(origin.read_bytes() if origin and origin.is_file() else b"").hexdigest()


@contextmanager
def _current_folder_importable() -> Iterator[None]:
    """Search the current folder too, after everything installed, and see files written a moment ago."""
    folder = os.getcwd()
    added = folder not in sys.path
    if added:
        sys.path.append(folder)
    importlib.invalidate_caches()
    try:
        yield
    finally:
        if added:
            sys.path.remove(folder)
