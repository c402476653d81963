"""The package loads lazily and keeps to itself."""

import subprocess
import sys
from importlib import import_module

import pytest

import fusion
import fusion.features
import fusion.neural


@pytest.mark.parametrize("package", [fusion, fusion.features, fusion.neural])
def test_every_public_name_resolves(package):
    for home in package._HOME.values():
        import_module(home)  # a submodule of a public name's name would stand in its way from then on
    for name in package.__all__:
        assert callable(getattr(package, name))
        assert getattr(package, name).__doc__
        assert name in dir(package)
    with pytest.raises(AttributeError, match="no attribute 'KSB'"):
        _ = package.KSB


def test_importing_the_package_loads_nothing_heavy_and_no_other_part():
    code = (
        "import sys, fusion, fusion.features\n"
        "heavy = {'torch', 'torchvision', 'sklearn', 'scipy', 'cv2', 'onnx', 'onnxruntime', 'pandas',"
        " 'vtbench', 'sensors', 'slip', 'leaderboard'}\n"
        "print(*sorted(heavy & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []
