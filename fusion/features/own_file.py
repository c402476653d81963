"""A backbone of one's own: an ONNX file that is shaped as `vt_vgg.onnx` is, named by its content."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

SUFFIX = ".onnx"
PROBE_SIDE = 256  # pixels of the frame that is sent through, where the file leaves height and width open


@dataclass(frozen=True)
class OwnFile:
    """What was found in a file.

    Attributes
    ----------
    name : stem and first eight digits of the SHA-256, so that two files never share one.
    dim : features per image.
    size : (height, width) of the frames that it takes; None where it takes any.
    """

    path: Path
    name: str
    dim: int
    size: tuple[int | None, int | None]
    size_bytes: int
    sha256: str

    def content(self) -> bytes:
        """The bytes that were looked at; OSError where the file has changed since."""
        content = self.path.read_bytes()
        if hashlib.sha256(content).hexdigest() != self.sha256:
            raise OSError(f"{self.path}: the file has changed since it was first read; run again")
        return content


def is_own_file(name: str) -> bool:
    """Whether a backbone's name is the path of a file."""
    return name.endswith(SUFFIX)


def read_own_file(path: Path) -> OwnFile:
    """The file at `path`, after one grey frame went through it.

    It takes `images` uint8 (N, height, width, 3) and gives `features` (N, columns) float32; height and width may be
    fixed. ValueError, in one line, for anything else.
    """
    if not path.is_file():
        raise ValueError(f"no backbone {str(path)!r}: expected an ONNX file, or a name (`vtbench list backbones`)")
    content = path.read_bytes()
    session = _opened(path, content)
    given, made = session.get_inputs(), session.get_outputs()
    wanted = "expected one input 'images' uint8 (N, height, width, 3)"
    if [each.name for each in given] != ["images"] or not _takes_frames(given[0]):
        raise ValueError(f"{path}: {wanted}, got {_listed(given)}")
    if "features" not in [each.name for each in made]:
        raise ValueError(f"{path}: expected an output 'features' float32 (N, columns), got {_listed(made)}")
    height, width = (side if isinstance(side, int) else None for side in given[0].shape[1:3])
    frame = np.full((1, height or PROBE_SIDE, width or PROBE_SIDE, 3), 128, np.uint8)
    try:
        (features,) = session.run(["features"], {"images": frame})
    except Exception as error:
        raise ValueError(f"{path}: does not take a frame of shape {frame.shape} ({_first_line(error)})") from error
    if features.ndim != 2 or features.shape[0] != 1 or not features.shape[1] or features.dtype != np.float32:
        raise ValueError(
            f"{path}: expected 'features' float32 (N, columns), got {features.dtype} {features.shape} of one frame"
        )
    digest = hashlib.sha256(content).hexdigest()
    name = f"{re.sub(r'[^A-Za-z0-9_.-]+', '-', path.stem)}-{digest[:8]}"
    return OwnFile(path.resolve(), name, features.shape[1], (height, width), len(content), digest)


def _opened(path: Path, content: bytes) -> Any:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4
    options.intra_op_num_threads = 1
    try:
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise ValueError(f"{path}: not a model that ONNX Runtime opens ({_first_line(error)})") from error


def _takes_frames(port: Any) -> bool:
    """Whether it is uint8 (N, height, width, 3); an open size is text or None, and one frame a call is enough."""
    if port.type != "tensor(uint8)" or len(port.shape) != 4:
        return False
    n, _, _, channels = (side if isinstance(side, int) else None for side in port.shape)
    return n in (None, 1) and channels in (None, 3)


def _listed(ports: list[Any]) -> str:
    return ", ".join(f"{each.name!r} {each.type[7:-1]} {tuple(each.shape)}" for each in ports) or "none"


def _first_line(error: Exception) -> str:
    text = str(error).strip()
    return text.splitlines()[0][:160] if text else type(error).__name__
