"""GelSight ball presses: 24 real frames of a ball of 2 mm radius pressed into a GelSight, with the untouched frame.

The even-numbered half of the 48 frames that the package `taxim` 1.4.0 ships. Calibrations may see the numbers divisible
by 4, scores use the other even ones; the odd ones are reserved for checks from outside: `vtbench fetch` drops them
without looking. Centres and contact radii are the published ones.

Source: github.com/TimSchneider42/taxim (MIT), with the method of Z. Si, W. Yuan, "Taxim: an example-based simulation
model for GelSight tactile sensors", IEEE RA-L 7(2), 2022.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from sensors.ball_press import BallPress, BallPresses
from vtbench.data.png import decode_png, encode_png
from vtbench.data.public import MANIFESTS, PublicSet, data_root

_PACK = "dataPack.npz"
_COLUMNS = ("file", "center_x_px", "center_y_px", "contact_radius_px")
_FOLDER = "gelsight"
_REST = "background.png"
BALL_RADIUS_MM = 2.0
PIXEL_MM = 0.0295


def keep_even_presses(downloaded: Path, root: Path) -> None:
    """Turn the published archive below `downloaded` into the folder `root`: even presses as PNG, and presses.csv.

    The archive holds plain arrays only; the odd ones are dropped by their place.
    """
    folder = root / _FOLDER
    folder.mkdir(parents=True)
    with np.load(downloaded / _PACK, allow_pickle=False) as pack:
        rest, centers, radii = pack["f0"], pack["touch_center"][::2], pack["touch_radius"][::2]
        frames = pack["imgs"][::2]
    images = {_REST: rest} | {f"press_{2 * place:02d}.png": frame for place, frame in enumerate(frames)}
    for name, image in images.items():
        (folder / name).write_bytes(encode_png(image[..., ::-1]))  # the archive's channels are BGR
    lines = [",".join(_COLUMNS)]
    for place, ((x, y), radius) in enumerate(zip(centers.tolist(), radii.tolist(), strict=True)):
        lines.append(f"press_{2 * place:02d}.png,{x},{y},{radius}")
    (folder / "presses.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


SOURCE = PublicSet(
    name="gelsight_ball_presses",
    title="24 real GelSight frames of a pressed ball, with contact circles and the untouched frame",
    licence="MIT",
    citation="Si and Yuan, IEEE RA-L 7(2), 2022; frames as shipped by github.com/TimSchneider42/taxim 1.4.0",
    homepage="https://github.com/TimSchneider42/taxim",
    base_url="https://media.githubusercontent.com/media/TimSchneider42/taxim/"
    "992086ba6b17d048639a3c4b0f4f668c377967a5/taxim/calib/gelsight",
    megabytes=45,
    manifest=MANIFESTS / "gelsight_ball_presses.sha256",
    unpack=keep_even_presses,
)


def load_gelsight_ball_presses(root: Path | str | None = None) -> BallPresses:
    """Load the even presses below `root`, by default from where `data_root` finds them.

    Raises:
        ValueError: not on this machine (the message names `vtbench fetch gelsight_ball_presses`), an odd-numbered
            press, or a file that is missing or not of the published form; it is named.
    """
    folder = (Path(root) if root is not None else data_root(SOURCE.name)) / _FOLDER
    table = folder / "presses.csv"
    if not table.is_file():
        raise ValueError(f"{table}: no such file; `vtbench fetch {SOURCE.name}` brings the presses")
    with table.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != _COLUMNS:
            raise ValueError(f"{table}: expected the columns {', '.join(_COLUMNS)}, got {reader.fieldnames}")
        presses = tuple(_press(folder, table, number, row) for number, row in enumerate(reader, start=2))
    if not presses:
        raise ValueError(f"{table}: no presses below the heading")
    return BallPresses(_image(folder / _REST), presses, BALL_RADIUS_MM, PIXEL_MM)


def _press(folder: Path, table: Path, line: int, row: dict[str, str]) -> BallPress:
    name = row["file"]
    digits = name.removeprefix("press_").removesuffix(".png")
    if not digits.isdecimal() or name != f"press_{digits}.png":
        raise ValueError(f"{table}, line {line}: expected a name such as press_04.png, got {name!r}")
    if int(digits) % 2:
        raise ValueError(f"{table}, line {line}: {name} is odd-numbered, and those are reserved; remove it")
    try:
        x, y, radius = (float(row[column]) for column in _COLUMNS[1:])
    except (TypeError, ValueError):
        raise ValueError(f"{table}, line {line}: expected numbers for {', '.join(_COLUMNS[1:])}") from None
    if not (np.isfinite([x, y, radius]).all() and radius > 0):
        raise ValueError(f"{table}, line {line}: expected finite pixels and a positive radius, got {x}, {y}, {radius}")
    return BallPress(int(digits), _image(folder / name), x, y, radius)


def _image(path: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    if not path.is_file():
        raise ValueError(f"{path}: no such file; `vtbench fetch {SOURCE.name}` brings the presses")
    try:
        return decode_png(path.read_bytes())
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
