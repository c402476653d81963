"""What a method is: a classifier, and what is chosen about it on training folds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from vtbench.tasks.base import Feed

Groups = Mapping[str, slice]
Params = Mapping[str, Any]


class Classifier(Protocol):
    """What scikit-learn calls a classifier, as far as a run needs it."""

    def fit(self, X: NDArray[np.floating], y: NDArray[np.int64]) -> Any:
        """Learn from X (n, columns) and labels y (n,)."""

    def predict(self, X: NDArray[np.floating]) -> NDArray[np.int64]:
        """Labels (q,) of X (q, columns)."""


@dataclass(frozen=True)
class Method:
    """A classifier with the choices it leaves to the training folds.

    Attributes:
        id: as suites and tables name it.
        about: one line for listings.
        build: (column groups, weights of the groups, parameters) -> unfitted classifier.
        choices: parameter -> values that are tried, the default first.
        joint: needs two modalities; on a single one it would be another method of this list.
        weighs_groups: takes the weights itself instead of finding them in the scale of the columns.
        preprocess: `scaled`: each modality standardised, reduced and brought to mean squared norm 1;
            `none`: columns as they come, for a method that brings its own.
        shaped: takes only feeds whose every block says how its columns fold.
        learns: finds weights and stopping point itself: none are tried, and `fit` takes the inner groups as `groups`.
        source: what else decides its results (parameters, checksum of the code), part of a record's key.
    """

    id: str
    about: str
    build: Callable[[Groups, Mapping[str, float], Params], Classifier]
    choices: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    joint: bool = False
    weighs_groups: bool = False
    preprocess: Literal["scaled", "none"] = "scaled"
    shaped: bool = False
    learns: bool = False
    source: Mapping[str, Any] = field(default_factory=dict)

    def takes(self, feed: Feed) -> bool:
        """Whether a feed is one for this method."""
        return (len(feed.blocks) > 1 or not self.joint) and (feed.shaped or not self.shaped)

    def identity(self) -> dict[str, Any]:
        """JSON values that decide the method's results."""
        return {
            "choices": {name: list(values) for name, values in self.choices.items()},
            "preprocess": self.preprocess,
            **self.source,
        }
