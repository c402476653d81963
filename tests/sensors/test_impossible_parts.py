"""Parts that cannot be are refused where they are built, NaN and infinity among them, and never answer with NaN."""

from dataclasses import fields, replace

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.ladder.interface import Pad
from sensors.contact.layer import LayerMaterial
from sensors.contact.skin import SkinMaterial
from sensors.cpm_finger import FABRICS, CPMFingerParameters
from sensors.digit import DigitParameters
from sensors.electronics.capacitive import CapacitiveChain
from sensors.electronics.creep import Creep
from sensors.electronics.hysteresis import PrandtlIshlinskii
from sensors.electronics.piezoresistive import PiezoresistiveChain
from sensors.electronics.spread import ArrayTraits
from sensors.friction.pad import PadSpring
from sensors.gelsight import GelSightParameters
from sensors.taxel_pad import TaxelPadParameters
from sensors.two_pad_grasp import Grasp, lift_cube

GEL = LayerMaterial(3e-3, 1e5, 0.45)
STILL = ArrayTraits.draw(np.random.default_rng(0), 4)
PARTS = [
    (LayerMaterial, (3e-3, 1e5, 0.45)),
    (Grid, (8, 1e-2)),
    (PadSpring, (300.0, 0.3, 1e-3)),
    (lambda side: Pad(GEL, side), (1e-2,)),
    (lambda tension: SkinMaterial(GEL, tension), (600.0,)),
    (lambda tau, depth, closing: Creep((tau,), (depth,), closing), (0.3, 0.1, 0.3)),
    (lambda threshold, weight: PrandtlIshlinskii((threshold,), (weight,)), (0.5, 0.1)),
    (lambda *spreads: ArrayTraits.draw(np.random.default_rng(0), 4, *spreads), (0.03, 0.1, 0.1)),
    (lambda *drifts: STILL.drift(np.random.default_rng(0), *drifts), (0.01, 0.02)),
    (lambda *numbers: CapacitiveChain(*numbers), (0.5, 4.0, 4800.0, 5.0, 28.0, 1.0, 4095.0)),
    (lambda mm: replace(FABRICS["fine"], warp_mm=mm), (0.5,)),
    (lambda mm: replace(FABRICS["fine"], relief_mm=mm), (0.5,)),
]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize(("build", "good"), PARTS, ids=range(len(PARTS)))
def test_no_number_of_a_part_may_be_nan_infinite_or_negative(build, good, bad):
    build(*good)
    for place in range(len(good)):
        with pytest.raises(ValueError, match=r"\w"):
            build(*good[:place], bad, *good[place + 1 :])


def test_a_grid_has_a_whole_number_of_cells():
    assert Grid(np.int64(8), 1.0) == Grid(8, 1.0)
    with pytest.raises(ValueError, match=r"whole n >= 2 .* got n=8\.5"):
        Grid(8.5, 1.0)


@pytest.mark.parametrize("model", [TaxelPadParameters, CPMFingerParameters, DigitParameters, GelSightParameters])
def test_every_number_of_a_sensor_is_finite(model):
    numbers = [name for name, value in model() if type(value) is float]
    assert numbers
    for name in numbers:
        with pytest.raises(ValueError, match=rf"{name}\n.*finite"):
            model(**{name: np.inf})


@pytest.mark.parametrize("chain", [CapacitiveChain(), PiezoresistiveChain()], ids=["capacitive", "piezoresistive"])
@pytest.mark.parametrize("gain", [np.nan, np.inf, -1.0, np.array([1.0, np.nan])], ids=str)
def test_a_chain_reads_no_taxel_of_a_senseless_gain(chain, gain):
    rate = {"rate_hz": 1000.0} if isinstance(chain, CapacitiveChain) else {}
    assert np.isfinite(chain.read(np.ones((50, 2)), **rate, gain=1.5)[-1]).all()
    with pytest.raises(ValueError, match="finite gain >= 0"):
        chain.read(np.ones((50, 2)), **rate, gain=gain)


@pytest.mark.parametrize("name", [field.name for field in fields(Grasp)])
def test_a_grasp_has_finite_numbers(name):
    for bad in (np.nan, np.inf) if name == "offset_mm" else (np.nan, np.inf, -1.0):
        with pytest.raises(ValueError, match=rf"a grasp needs .*{name}"):
            lift_cube(Grasp(**{name: bad}))
    if name == "grip_n":
        with pytest.raises(ValueError, match="grip_n > 0"):
            lift_cube(Grasp(grip_n=0.0))
