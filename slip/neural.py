"""Learnt detectors: a causal convolutional net over force differences, alone or with the camera's frames.

Torch is needed to learn only; scores are computed in NumPy, in double precision, streamed or in a batch.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from slip.detector import DifferenceDetector, Stream
from slip.differences import CommonMode
from slip.net import HeldEmbedding, Net, NetShape, NetStream
from slip.net_camera import Camera, embeddings
from slip.net_file import read_net, write_net
from slip.net_fit import fit_net
from slip.net_pieces import Partial
from slip.samples import Floats, Missing
from slip.training_trial import TrainingTrial, checked_frames, latest_frame

if TYPE_CHECKING:
    from slip.net_training import Epoch


class NeuralForce(DifferenceDetector):
    """-log P(no slip) of a causal convolutional net over the last `window` force differences.

    The differences are divided by `scale`: the noise of the training trials while they stick, unless one is given;
    `with_scale` puts in another sensor's rest noise instead. See `DifferenceDetector` for the other parameters.

    Parameters
    ----------
    channels, levels, hidden : size of the net; `window` is 2^(levels + 1) - 1 differences.

    Attributes
    ----------
    history_ : losses of each epoch, on the training and on the validation trials.
    epoch_ : the epoch whose weights were kept, from 0.

    """

    def __init__(
        self,
        *,
        channels: int = 24,
        levels: int = 7,
        hidden: int = 16,
        common_mode: CommonMode = "keep",
        scale: ArrayLike | None = None,
        nan: Missing = "refuse",
    ) -> None:
        self._become(NetShape(taxels=1, channels=channels, levels=levels, hidden=hidden), None)
        super().__init__(self.window, common_mode=common_mode, scale=scale, nan=nan)
        self._given_scale = self.scale

    def _become(self, shape: NetShape, net: Net | None) -> None:
        self._shape, self._net, self.window = shape, net, shape.reach

    @property
    def net(self) -> Net:
        """The trained net. Raises ValueError before `fit`."""
        if self._net is None:
            raise ValueError(f"this {type(self).__name__} has learnt nothing yet: call fit or slip.load_detector")
        return self._net

    def fit(
        self,
        trials: Iterable[TrainingTrial],
        validation: Iterable[TrainingTrial] | None = None,
        *,
        epochs: int = 30,
        batch: int = 8,
        learning_rate: float = 8e-3,
        partial: Partial = "ignore",
        seed: int = 0,
        device: str = "cpu",
        progress: bool = False,
    ) -> Self:
        """Learn slip from trials; the weights kept are those of the epoch with the least loss on `validation`.

        validation : trials that no weight is learnt from; without them every fifth trial, drawn by `seed`, is held
            back. Take them from the training part of a split, never from its test part.
        partial : "ignore" leaves samples of partial slip out of the loss; "stick" and "slip" count them so.
        batch : pieces of 1000 samples to a step; device : "cpu" or "cuda".

        Trials may come from a generator: their frames are let go once looked at.

        The same seed gives the same weights on one CPU thread. Raises ValueError for trials without both stick
        and slip, of different taxels, or without the frames that the net looks at.
        """
        from slip.net_training import Schedule

        if partial not in ("ignore", "stick", "slip"):
            raise ValueError(f'expected partial to be "ignore", "stick" or "slip", got {partial!r}')
        fitted = fit_net(
            self._shape,
            lambda force: self.with_scale(np.ones(force.shape[1])).treated_differences(force),
            self._given_scale,
            trials,
            validation,
            Schedule(epochs, batch, learning_rate),
            partial=partial,
            seed=seed,
            device=device,
            progress=progress,
        )
        self._become(fitted.net.shape, fitted.net)
        self.scale = fitted.scale
        self.history_: list[Epoch] = fitted.history
        self.epoch_: int = fitted.epoch
        self.reset()
        return self

    def save(self, path: str | Path) -> Path:
        """Write the detector to one .npz file without pickle; `slip.load_detector` reads it."""
        header = {"detector": type(self).__name__, "common_mode": self.common_mode, "nan": self.nan}
        return write_net(Path(path), self.net, np.asarray(self.scale), header)

    def _check_taxels(self, taxels: int) -> None:
        if taxels != self.net.shape.taxels:
            raise ValueError(f"expected {self.net.shape.taxels} taxels, as the net has learnt, got {taxels}")
        super()._check_taxels(taxels)

    def _start(self, taxels: int) -> Stream:
        return NetStream(self.net, HeldEmbedding(0))

    def _score_differences(self, differences: Floats) -> Floats:
        return self.net.scores(differences, np.zeros((len(differences), 0)))


class NeuralForceFrames(NeuralForce):
    """`NeuralForce` that also looks at the camera: how each frame differs from the one before it, on a coarse grid.

    A frame's embedding, made of its change and the two before, holds until the next frame comes. Before the first
    frame, or without any, the net has forces alone; it has learnt a quarter of its pieces so.

    Parameters
    ----------
    embedding : numbers that a frame comes down to. grid : cells along each side of a frame, a multiple of 4.

    """

    def __init__(
        self,
        *,
        channels: int = 24,
        levels: int = 7,
        hidden: int = 16,
        embedding: int = 8,
        grid: int = 16,
        common_mode: CommonMode = "keep",
        scale: ArrayLike | None = None,
        nan: Missing = "refuse",
    ) -> None:
        if embedding < 1:
            raise ValueError(f"expected an embedding of at least 1 number, got {embedding!r}")
        super().__init__(channels=channels, levels=levels, hidden=hidden, common_mode=common_mode, scale=scale, nan=nan)
        shape = NetShape(1, channels, levels, hidden, embedding=embedding, grid=grid)
        self._become(shape, None)

    def reset(self) -> None:
        """Forget every sample and frame and the count of skipped samples."""
        super().reset()
        self._camera: Camera | None = None

    def update(self, sample: ArrayLike, time_s: float | None = None, *, frame: ArrayLike | None = None) -> float:
        """Take one sample (taxels,) in newtons and the frame (H, W, 3) uint8 that came with it; return the score.

        Raises ValueError as `DifferenceDetector.update`, and for another shape or type of frame.
        """
        if frame is not None:
            images, _ = checked_frames(np.asarray(frame)[None], [0])
            self._eye().push(images[0])
        return super().update(sample, time_s)

    def score(
        self,
        sequence: ArrayLike,
        time_s: ArrayLike | None = None,
        *,
        frames: ArrayLike | None = None,
        frame_samples: ArrayLike | None = None,
    ) -> Floats:
        """Score each sample of (T, taxels) newtons as a fresh stream would; (T,).

        frames : (F, H, W, 3) uint8; frame_samples : (F,) the sample that each came with, rising. Raises ValueError.
        """
        force, kept = self._checked(sequence, time_s)
        held = np.zeros((len(kept), self.net.shape.embedding))
        if frames is not None:
            images, at = checked_frames(frames, frame_samples)
            told = np.concatenate([np.zeros((1, held.shape[1])), embeddings(self.net, images)])
            held = told[latest_frame(at, len(kept))]
        return self._spread(self.net.scores(self.treated_differences(force), held[kept]), kept)

    def _start(self, taxels: int) -> Stream:
        return NetStream(self.net, self._eye())

    def _eye(self) -> Camera:
        if self._camera is None:
            self._camera = Camera(self.net)
        return self._camera

    def _score_differences(self, differences: Floats) -> Floats:
        return self.net.scores(differences, np.zeros((len(differences), self.net.shape.embedding)))


def load_detector(path: str | Path) -> NeuralForce:
    """Read what `save` wrote. Raises OSError, or ValueError for another file."""
    net, scale, header = read_net(Path(path))
    detector: NeuralForce = NeuralForceFrames() if net.shape.embedding else NeuralForce()
    if header.get("detector") != type(detector).__name__:
        raise ValueError(f"{path} holds a {header.get('detector')!r}, expected a {type(detector).__name__}")
    detector = type(detector)(scale=scale, common_mode=header["common_mode"], nan=header["nan"])
    detector._become(net.shape, net)
    detector.reset()
    return detector
