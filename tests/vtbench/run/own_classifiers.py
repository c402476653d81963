"""Classifiers of somebody's own, for tests of a run; importable by worker processes."""

import os
import sys
import time
from pathlib import Path

import numpy as np


class Nearest:
    """Nearest class mean; every fit leaves a line in `log`."""

    def __init__(self, log="", delay_s=0.0, power=1):
        self.log = log
        self.delay_s = delay_s
        self.power = power

    def fit(self, x, y):
        if self.log:
            with Path(self.log).open("a") as file:
                file.write(f"{len(y)}\n")
        time.sleep(self.delay_s)
        self.classes_ = np.unique(y)
        self.means_ = np.stack([x[y == label].mean(0) for label in self.classes_])
        return self

    def predict(self, x):
        return self.classes_[np.argmax(self.decision_function(x), 1)]

    def decision_function(self, x):
        return -(np.abs(x[:, None] - self.means_) ** (2 * self.power)).sum(2)


class Raises(Nearest):
    def fit(self, x, y):
        raise ZeroDivisionError("no\nanswer")


class RaisesLate(Nearest):
    def predict(self, x):
        raise RuntimeError("lost its memory")


class OneTooMany(Nearest):
    def predict(self, x):
        return np.append(super().predict(x), 0)


class Column(Nearest):
    def predict(self, x):
        return super().predict(x)[:, None]


class NaN(Nearest):
    def predict(self, x):
        return np.full(len(x), np.nan)


class UnseenLabel(Nearest):
    def predict(self, x):
        return np.full(len(x), 99)


class Negative(Nearest):
    def predict(self, x):
        return np.full(len(x), -1)


class Text(Nearest):
    def predict(self, x):
        return np.full(len(x), "ball")


class Halves(Nearest):
    def predict(self, x):
        return np.full(len(x), 0.5)


class NaNScores(Nearest):
    def predict(self, x):
        return np.full(len(x), self.classes_[0])

    def decision_function(self, x):
        return np.full((len(x), len(self.classes_)), np.nan)


class Exits(Nearest):
    def fit(self, x, y):
        sys.exit()


class WholeFloats(Nearest):
    def predict(self, x):
        return super().predict(x).astype(float)


class Dies(Nearest):
    def fit(self, x, y):
        os._exit(1)


class NoPredict:
    def fit(self, x, y):
        return self


def not_a_class():
    return Nearest()
