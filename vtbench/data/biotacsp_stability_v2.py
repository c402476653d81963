"""BioTac SP Stability Set v2: does a grasp hold when the object is lifted?

5,831 grasps of 51 objects by a hand with three BioTac SP fingertips, one reading of 3 x 24 electrodes before the lift,
in three poses of the palm; 41 objects to learn from and 10 others to be tested on. Raw counts, no time axis.

Source: Garcia-Garcia, Zapata-Impata, Orts-Escolano, Gil, Garcia-Rodriguez, "TactileGCN: a graph convolutional network
for predicting grasp stability with tactile sensors", IJCNN 2019.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from vtbench.data.public import MANIFESTS, PublicSet, data_root

SOURCE = PublicSet(
    name="biotacsp_stability_v2",
    title="5,831 grasps with three BioTac SP fingertips, stable or slipped, 41 objects and 10 unseen ones",
    licence="MIT",
    citation="Garcia-Garcia et al., TactileGCN, IJCNN 2019",
    homepage="https://github.com/3dperceptionlab/biotacsp-stability-set-v2",
    base_url="https://raw.githubusercontent.com/3dperceptionlab/biotacsp-stability-set-v2/"
    "50245a427e522bbe476039b203a408767195e065",
    megabytes=3,
    manifest=MANIFESTS / "biotacsp_stability_v2.sha256",
)

PALMS = ("down", "side", "45")
FINGERS = ("ff", "mf", "th")
N_ELECTRODES = 24
COLUMNS = ("object", "slipped", *(f"{finger}_biotac_{at}" for finger in FINGERS for at in range(1, N_ELECTRODES + 1)))


@dataclass(frozen=True)
class Grasps:
    """The grasps, training objects first; entry i of every attribute is grasp i.

    Attributes:
        electrodes: counts (n, 72) float64, by finger (first, middle, thumb), then electrode.
        slipped: (n,) bool, whether the object fell or moved when it was lifted.
        object: names, (n,) str.
        palm: pose of the palm, (n,) str of `PALMS`.
        unseen: (n,) bool, one of the ten objects kept for testing.
        id: (n,) str, file and line (the heading is line 1).
    """

    electrodes: NDArray[np.float64]
    slipped: NDArray[np.bool_]
    object: NDArray[np.str_]
    palm: NDArray[np.str_]
    unseen: NDArray[np.bool_]
    id: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.slipped)


def load_biotacsp_stability_v2(root: Path | str | None = None) -> Grasps:
    """Load the grasps below `root`, by default from where `data_root` finds them.

    Raises:
        ValueError: not on this machine (the message names `vtbench fetch biotacsp_stability_v2`), a file that is
            missing or not of the published columns, a cell that is no whole number; the file is named.
    """
    folder = Path(root) if root is not None else data_root(SOURCE.name)
    files = [(palm, unseen) for unseen in (False, True) for palm in PALMS]
    names = [f"bts3v2_palm_{palm}{'_test' if unseen else ''}.csv" for palm, unseen in files]
    tables = [_read(folder / name) for name in names]
    lengths = [len(table) for table in tables]
    whole = pd.concat(tables, ignore_index=True)
    return Grasps(
        electrodes=whole[list(COLUMNS[2:])].to_numpy(np.float64),
        slipped=whole["slipped"].to_numpy(np.int64) == 1,
        object=whole["object"].to_numpy(np.str_),
        palm=np.repeat([palm for palm, _ in files], lengths),
        unseen=np.repeat([unseen for _, unseen in files], lengths),
        id=np.array(
            [f"{name}:{line + 2}" for name, length in zip(names, lengths, strict=True) for line in range(length)]
        ),
    )


def _read(path: Path) -> pd.DataFrame:
    try:
        table = pd.read_csv(path, skipinitialspace=True)
    except FileNotFoundError:
        raise ValueError(f"{path}: no such file; `vtbench fetch {SOURCE.name}` brings it") from None
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not readable as CSV ({' '.join(str(error).split())})") from error
    if tuple(table.columns) != COLUMNS:
        raise ValueError(f"{path}: expected the columns object, slipped, ff_biotac_1, ... th_biotac_24, got others")
    for column in COLUMNS[1:]:
        if table[column].dtype.kind != "i":
            raise ValueError(f"{path}: column {column!r} holds something that is no whole number")
    if not table["slipped"].isin((0, 1)).all():
        raise ValueError(f"{path}: column 'slipped' holds something else than 0 and 1")
    return table
