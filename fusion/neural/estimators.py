"""Fusion nets as scikit-learn classifiers: learnt with torch, predicted with NumPy, kept without pickle."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import check_random_state
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from fusion.neural.files import KeptNet, read_net, write_net
from fusion.neural.folds import held_back_folds
from fusion.neural.late_fusion import LateFusion
from fusion.neural.layout import FloatArray, Layout
from fusion.neural.net import Net
from fusion.neural.ops import NumpyOps
from fusion.neural.transformer import Transformer
from fusion.seen import seen_columns_only
from fusion.settings import not_negative, positive, share, whole_number

ROWS = 128  # predicted at once


class _FusionNet(ClassifierMixin, BaseEstimator, ABC):  # type: ignore[misc]
    """What both nets share; each states its own parameters."""

    def fit(self, X: ArrayLike, y: ArrayLike, groups: ArrayLike | None = None) -> Self:
        """Learn from X (n, d) and labels y (n,).

        groups : (n,) condition, such as the sensor, that the validation folds hold back whole.
        """
        data, labels = validate_data(self, X, y, dtype=np.float64)
        check_classification_targets(labels)
        self._check_parameters()
        self.classes_, target = np.unique(labels, return_inverse=True)
        self._net = self._sized(Layout.of(self.modalities, self.shapes, data.shape[1]), len(self.classes_))
        if groups is not None and np.shape(groups) != (len(data),):
            raise ValueError(f"groups must be one a row, ({len(data)},), got shape {np.shape(groups)}.")
        self._learn(data, target.astype(np.int64), None if groups is None else np.asarray(groups))
        return self

    def decision_function(self, X: ArrayLike, *, missing: Collection[str] = ()) -> FloatArray:
        """Logits: (q, n_classes), or (q,) second minus first class where there are two."""
        logits = self._logits(X, missing)
        return logits[:, 1] - logits[:, 0] if len(self.classes_) == 2 else logits

    def predict_proba(self, X: ArrayLike, *, missing: Collection[str] = ()) -> FloatArray:
        """Softmax of the logits: (q, n_classes)."""
        return np.asarray(NumpyOps().softmax(self._logits(X, missing)))

    def predict(self, X: ArrayLike, *, missing: Collection[str] = ()) -> NDArray[Any]:
        """Label of each row of X (q, d); ties go to the first class."""
        winner = np.argmax(self._logits(X, missing), axis=1)
        return np.asarray(self.classes_[winner])

    def save(self, path: Path | str) -> Path:
        """Write the fitted net to one .npz of plain arrays, whole or not at all; no pickle."""
        check_is_fitted(self, "_weights")
        kept = KeptNet(
            type(self).__name__,
            {**self.get_params(), "modalities": self._modality_columns()},
            self.n_features_in_,
            self.n_epochs_,
            self._scales,
            self._weights,
            self.classes_,
            self.validation_loss_,
        )
        return write_net(Path(path), kept)

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """The net that `save` wrote; ValueError for another file, OSError where there is none."""
        kept = read_net(Path(path))
        if kept.kind != cls.__name__:
            raise ValueError(f"{path} holds a {kept.kind}: load it with {kept.kind}.load.")
        net = cls(**kept.params)
        net.classes_, net.n_features_in_ = kept.classes, kept.n_features
        net.n_epochs_, net.validation_loss_ = kept.n_epochs, kept.validation_loss
        net._net = net._sized(Layout.of(net.modalities, net.shapes, kept.n_features), len(kept.classes))
        net._weights, net._scales = dict(kept.weights), dict(kept.scales)
        return net

    def _modality_columns(self) -> dict[str, tuple[int, ...]] | None:
        """Column numbers of each modality, whatever they were given as."""
        if self.modalities is None:
            return None
        return {part.name: part.columns for part in self._net.layout.parts}

    @abstractmethod
    def _sized(self, layout: Layout, n_classes: int) -> Net:
        """The net of this kind for a layout and so many classes."""

    def _learn(self, data: FloatArray, target: NDArray[np.int64], groups: NDArray[Any] | None) -> None:
        import torch

        from fusion.neural.training import Schedule, learn, torch_device

        torch_device(self.device)
        schedule = Schedule(
            self.epochs,
            self.batch_size,
            self.learning_rate,
            self.weight_decay,
            self.noise,
            self.label_smoothing,
            self.modality_dropout,
        )
        seed = int(check_random_state(self.random_state).randint(2**31))
        whole, dealt, *folds_rng = np.random.default_rng(seed).spawn(2 + self.validation_folds)
        folds = held_back_folds(target, groups, self.validation_folds, dealt) if self.validation_folds else []
        threads = torch.get_num_threads()
        torch.set_num_threads(1)  # small layers gain nothing from more, and the sums keep their order
        try:
            losses = [
                learn(
                    self._net,
                    data[rows],
                    target[rows],
                    schedule,
                    rng=rng,
                    device=self.device,
                    held_back=(data[held], target[held]),
                ).held_back_loss
                for (rows, held), rng in zip(folds, folds_rng, strict=False)
            ]
            self.validation_loss_ = np.mean(losses, axis=0) if losses else np.empty(0)
            self.n_epochs_ = int(np.argmin(self.validation_loss_)) + 1 if losses else self.epochs
            learnt = learn(self._net, data, target, schedule, rng=whole, device=self.device, stop=self.n_epochs_)
            self._weights, self._scales = learnt.weights, learnt.scales
        finally:
            torch.set_num_threads(threads)

    def _logits(self, X: ArrayLike, missing: Collection[str]) -> FloatArray:
        check_is_fitted(self, "_weights")
        layout = self._net.layout
        there = [part for part, seen in zip(layout.parts, layout.present(missing), strict=True) if seen]
        columns = {part.name: list(part.columns) for part in layout.parts}
        data = seen_columns_only(self, X, columns, [part.name for part in there])
        logits = []
        for start in range(0, len(data), ROWS):
            rows = data[start : start + ROWS]
            parts = {part.name: self._scales[part.name].apply(part.of(rows)) for part in there}
            logits.append(self._net.logits(NumpyOps(), self._weights, parts))
        return np.concatenate(logits)

    def _check_parameters(self) -> None:
        for name, least in self._LEAST.items():
            whole_number(name, getattr(self, name), least)
        if self.validation_folds == 1:
            raise ValueError("validation_folds must be 0 or at least 2: one fold would leave nothing to learn from.")
        positive("learning_rate", self.learning_rate)
        for name in ("weight_decay", "noise"):
            not_negative(name, getattr(self, name))
        for name in ("label_smoothing", "modality_dropout"):
            share(name, getattr(self, name))

    _LEAST: ClassVar[Mapping[str, int]] = {"epochs": 1, "batch_size": 1, "validation_folds": 0, "width": 2}


class LateFusionNet(_FusionNet):
    """Classify with an encoder for each modality, joined in the last hidden layer.

    Parameters
    ----------
    modalities : name -> columns of X (a slice or an array of column numbers), or None for one modality of all.
    shapes : name -> how its columns fold: (channels, rows, columns) is an image, (steps, channels) a series,
        (columns,), or not named, a vector. One number may be -1.
    width : numbers in which every modality ends.
    epochs : most passes over the training rows; the rate rises, then falls along a cosine over all of them.
    batch_size, learning_rate, weight_decay, label_smoothing : of the cross-entropy and its optimiser, AdamW.
    noise : standard deviation of the noise on scaled inputs while learning.
    modality_dropout : share of the rows of a batch that lose some of their modalities, never all.
    validation_folds : folds of the training rows that are held back in turn to choose the number of epochs, by
        the mean loss over them; 0 keeps all epochs. The net is then learnt on all rows for that many.
    device : "cpu", or "cuda" to learn on a GPU; predictions are made on the CPU.
    random_state : same number, same net.

    Attributes
    ----------
    classes_ : (n_classes,) labels in order.
    n_epochs_ : epochs that the net was learnt for.
    validation_loss_ : (epochs,) mean loss on the folds held back; empty where none was.
    n_features_in_ : columns of X.

    Modalities are scaled by what the training rows say. A modality that is missing is named when predicting,
    `predict(X, missing=("image",))`: its columns are not looked at and may hold anything, NaN and infinity too. Where
    learning diverges `fit` raises ValueError.

    References
    ----------
    Neverova et al., "ModDrop: adaptive multi-modal gesture recognition", IEEE TPAMI 38(8), 2016 (modality dropout).
    """

    def __init__(
        self,
        modalities: Mapping[str, Any] | None = None,
        shapes: Mapping[str, Any] | None = None,
        *,
        width: int = 64,
        epochs: int = 40,
        batch_size: int = 32,
        learning_rate: float = 3e-3,
        weight_decay: float = 0.01,
        noise: float = 0.2,
        label_smoothing: float = 0.1,
        modality_dropout: float = 0.3,
        validation_folds: int = 2,
        device: str = "cpu",
        random_state: int | None = 0,
    ) -> None:
        self.modalities = modalities
        self.shapes = shapes
        self.width = width
        self.epochs = epochs
        self.batch_size = batch_size
        self.learning_rate = learning_rate
        self.weight_decay = weight_decay
        self.noise = noise
        self.label_smoothing = label_smoothing
        self.modality_dropout = modality_dropout
        self.validation_folds = validation_folds
        self.device = device
        self.random_state = random_state

    def _sized(self, layout: Layout, n_classes: int) -> Net:
        return LateFusion(layout, n_classes, self.width)


class FusionTransformer(_FusionNet):
    """Classify with a small transformer over image patches, taxels and stretches of time.

    Parameters
    ----------
    width : numbers a token.
    heads : of the attention, which share the width.
    layers : of the transformer.
    Other parameters, attributes, missing modalities : as in LateFusionNet.

    References
    ----------
    Vaswani et al., "Attention is all you need", NeurIPS 2017. Dosovitskiy et al., "An image is worth 16x16 words",
    ICLR 2021.
    """

    def __init__(
        self,
        modalities: Mapping[str, Any] | None = None,
        shapes: Mapping[str, Any] | None = None,
        *,
        width: int = 32,
        heads: int = 4,
        layers: int = 2,
        epochs: int = 40,
        batch_size: int = 32,
        learning_rate: float = 3e-3,
        weight_decay: float = 0.01,
        noise: float = 0.2,
        label_smoothing: float = 0.1,
        modality_dropout: float = 0.3,
        validation_folds: int = 2,
        device: str = "cpu",
        random_state: int | None = 0,
    ) -> None:
        self.modalities = modalities
        self.shapes = shapes
        self.width = width
        self.heads = heads
        self.layers = layers
        self.epochs = epochs
        self.batch_size = batch_size
        self.learning_rate = learning_rate
        self.weight_decay = weight_decay
        self.noise = noise
        self.label_smoothing = label_smoothing
        self.modality_dropout = modality_dropout
        self.validation_folds = validation_folds
        self.device = device
        self.random_state = random_state

    _LEAST: ClassVar[Mapping[str, int]] = {**_FusionNet._LEAST, "heads": 1, "layers": 1}

    def _sized(self, layout: Layout, n_classes: int) -> Net:
        if self.width % self.heads:
            raise ValueError(f"width must be a multiple of heads, got width={self.width} and heads={self.heads}.")
        return Transformer(layout, n_classes, self.width, self.heads, self.layers)
