"""Frames as PNG bytes and back, always in RGB order."""

from __future__ import annotations

import struct

import cv2
import numpy as np
from numpy.typing import NDArray

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_END = b"IEND\xaeB`\x82"

# Camera noise leaves no repeated strings to find: Huffman coding alone is both smaller and faster here.
_FAST = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]


def encode_png(image: NDArray[np.uint8]) -> bytes:
    """Encode an RGB frame (height, width, 3) uint8; lossless."""
    done, data = cv2.imencode(".png", image[..., ::-1], _FAST)
    if not done:
        raise ValueError(f"a frame of shape {image.shape} and type {image.dtype} cannot be encoded as PNG")
    return bytes(data)


def decode_png(data: bytes) -> NDArray[np.uint8]:
    """Decode PNG bytes to an RGB frame (height, width, 3) uint8; ValueError when they are damaged."""
    if (problem := png_problem(data)) is not None:
        raise ValueError(problem)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("damaged PNG data")
    rgb: NDArray[np.uint8] = np.ascontiguousarray(image[..., ::-1])
    return rgb


def png_problem(data: bytes | None) -> str | None:
    """Why these bytes are no whole PNG file, or None; looks only at both ends."""
    if not data:
        return "no image"
    if not data.startswith(_SIGNATURE):
        return "not PNG data"
    if not data.endswith(_END):
        return "truncated PNG data"
    return None


def png_size(data: bytes) -> tuple[int, int]:
    """(height, width) from the header of PNG bytes."""
    width, height = struct.unpack(">II", data[16:24])
    return height, width
