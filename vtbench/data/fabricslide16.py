"""FabricSlide16: a finger of 16 capacitive taxels slides over seven fabrics.

966 recordings of 7 fabrics x 5 grip settings x 6 speeds x 2 directions x 3 repetitions (some are missing), one every
28 ms over a stroke of 600 mm, and 24 of two boards. Raw counts; where each taxel lies is not published. A fabric is
also one recording session: a random split lets a classifier know the session, so hold out a grip setting as well.

Source: Wang, Albini, Maiolino, Mastrogiovanni, Cannata, "Fabric classification using a finger-shaped tactile sensor
via robotic sliding", Front. Neurorobot. 16, 2022, doi 10.3389/fnbot.2022.808222.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vtbench.data.counts_cache import cached_counts
from vtbench.data.public import MANIFESTS, PublicSet, data_root

SOURCE = PublicSet(
    name="fabricslide16",
    title="16 capacitive taxels sliding over 7 fabrics, 966 recordings, and over 2 boards, 24",
    licence="MIT",
    citation="Wang et al., Front. Neurorobot. 16, 2022, doi 10.3389/fnbot.2022.808222",
    homepage="https://github.com/wngfra/FabricSlide",
    base_url="https://raw.githubusercontent.com/wngfra/FabricSlide/eceb7716027cd1bcb5e614927f4cc2d0904adb25",
    megabytes=53,
    manifest=MANIFESTS / "fabricslide16.sha256",
)

PERIOD_MS = 28.0
N_TAXELS = 16
COLUMNS = ("timestamp", "proximity1", "proximity2", *(f"channel{i}" for i in range(1, N_TAXELS + 1)))
_NAME = re.compile(r"(?P<fabric>\w+)_F(?P<setting>\d+)_V(?P<speed>-?\d+)mmps_(?P<repetition>\d+)\.csv")


@dataclass(frozen=True)
class FabricSlide16:
    """The recordings, sorted by path; entry i of every attribute is recording i.

    Attributes:
        series: taxel counts, each (T, 16) float64.
        proximity: the two proximity channels' counts, each (T, 2) float64.
        time_ms: clock of the samples, each (T,) float64 milliseconds.
        fabric: names, (n,) str.
        setting: grip settings, (n,) int.
        speed: signed speeds, (n,) int mm/s.
        repetition: (n,) int.
        path: paths below the root.
    """

    series: list[NDArray[np.float64]]
    proximity: list[NDArray[np.float64]]
    time_ms: list[NDArray[np.float64]]
    fabric: NDArray[np.str_]
    setting: NDArray[np.int64]
    speed: NDArray[np.int64]
    repetition: NDArray[np.int64]
    path: list[str]

    def __len__(self) -> int:
        return len(self.series)


def load_fabricslide16(root: Path | str | None = None, kind: Literal["fabric", "board"] = "fabric") -> FabricSlide16:
    """Load the recordings of `kind` below `root`, by default from where `data_root` finds them, then complete.

    The parsed counts are kept in the cache and used while the files' sizes and times stay the same.

    Raises:
        ValueError: not on this machine (the message names `vtbench fetch fabricslide16`), a file that is
            missing, misnamed, or not of the published columns; it is named.
    """
    folder = Path(root) if root is not None else data_root(SOURCE.name)
    paths = sorted(path.relative_to(folder).as_posix() for path in folder.glob(f"data/{kind}/*.csv"))
    if root is None:
        expected = {path for path in SOURCE.files if path.startswith(f"data/{kind}/")}
        if lost := sorted(expected - set(paths)):
            raise ValueError(
                f"{folder}: {len(lost)} of {len(expected)} recordings are missing, {lost[0]} first; "
                f"`vtbench fetch {SOURCE.name}` brings them"
            )
    if not paths:
        raise ValueError(f"{folder}: no recordings data/{kind}/*.csv; `vtbench fetch {SOURCE.name}` brings them")
    conditions = [_condition(folder, path) for path in paths]
    rows, counts = cached_counts(f"{SOURCE.name}-{kind}", folder, paths, COLUMNS)
    stops = np.cumsum(rows)[:-1]
    values = counts.astype(np.float64)
    return FabricSlide16(
        series=np.split(values[:, 3:], stops),
        proximity=np.split(values[:, 1:3], stops),
        time_ms=np.split(values[:, 0], stops),
        fabric=np.array([condition["fabric"] for condition in conditions]),
        setting=np.array([int(condition["setting"]) for condition in conditions]),
        speed=np.array([int(condition["speed"]) for condition in conditions]),
        repetition=np.array([int(condition["repetition"]) for condition in conditions]),
        path=paths,
    )


def _condition(folder: Path, path: str) -> re.Match[str]:
    match = _NAME.fullmatch(path.rpartition("/")[2])
    if match is None:
        raise ValueError(
            f"{folder / path}: expected a name such as Canvas_F120_V-10mmps_0.csv (fabric, setting, speed, repetition)"
        )
    return match
