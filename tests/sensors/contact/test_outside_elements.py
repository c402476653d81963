"""The bonded layer against scikit-fem, a finite-element library that is not ours (skipped where it is missing)."""

import numpy as np
import pytest

from sensors.contact.layer import LayerMaterial
from sensors.contact.tangential import coupling_symbol, in_plane_symbols

skfem = pytest.importorskip("skfem")


def plane_wave(material: LayerMaterial, k: float, load: str) -> dict[str, float]:
    """Half a wave of the layer in plane strain by quadratic elements, under unit pressure cos kx or shear sin kx.

    Mirror planes (u_x = 0) at both ends make it the plane wave; amplitudes come out by projection.
    """
    from skfem.helpers import ddot, sym_grad, trace

    nu, h = material.poisson_ratio, material.thickness_m
    shear = material.youngs_modulus_pa / (2 * (1 + nu))
    lame = 2 * shear * nu / (1 - 2 * nu)
    length = np.pi / k
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, length, 17), np.linspace(0, h, 17))
    element = skfem.ElementVector(skfem.ElementQuad2())
    body = skfem.Basis(mesh, element)
    top = skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda x: np.isclose(x[1], h)))

    @skfem.BilinearForm
    def stiffness(u, v, _):
        return lame * trace(sym_grad(u)) * trace(sym_grad(v)) + 2 * shear * ddot(sym_grad(u), sym_grad(v))

    @skfem.LinearForm
    def traction(v, w):
        return -np.cos(k * w.x[0]) * v[1] if load == "pressure" else np.sin(k * w.x[0]) * v[0]

    @skfem.Functional
    def down(w):
        return -2 / length * np.cos(k * w.x[0]) * w["u"][1]

    @skfem.Functional
    def along(w):
        return 2 / length * np.sin(k * w.x[0]) * w["u"][0]

    matrix, right = stiffness.assemble(body), traction.assemble(top)
    base = body.get_dofs(lambda x: np.isclose(x[1], 0))
    ends = body.get_dofs(lambda x: np.isclose(x[0], 0) | np.isclose(x[0], length))
    held = np.union1d(base.all(), ends.all("u^1"))
    u = skfem.solve(*skfem.condense(matrix, right, D=held))
    # reactions of the base against cos kx: the normal stress there
    reaction = matrix @ u - right
    vertical = np.intersect1d(base.all("u^2"), base.all())
    wave = np.cos(k * body.doflocs[0, vertical])
    return {
        "down": float(down.assemble(top, u=top.interpolate(u))),
        "along": float(along.assemble(top, u=top.interpolate(u))),
        "base": float(2 / length * (reaction[vertical] * wave).sum()),
    }


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("kh", [0.5, 2.0])
def test_the_layers_symbols_are_those_of_an_outside_library(nu, kh):
    """Compliance, base pressure, in-plane motion under pressure and under shear, to 1e-3 of 16 x 16 quadratic cells."""
    material = LayerMaterial(2e-3, 1e6, nu)
    k = kh / material.thickness_m
    at = np.array([k])
    pressed, sheared = plane_wave(material, k, "pressure"), plane_wave(material, k, "shear")
    compliance = material.surface_compliance(at)[0]
    coupling = coupling_symbol(material, at)[0]
    assert pressed["down"] == pytest.approx(compliance, rel=1e-3)
    assert pressed["base"] == pytest.approx(material.base_transfer(at)[0], rel=1e-3)
    assert pressed["along"] == pytest.approx(coupling, abs=1e-3 * compliance)
    assert sheared["along"] == pytest.approx(in_plane_symbols(material, at)[0][0], rel=1e-3)
    assert sheared["down"] == pytest.approx(coupling, abs=1e-3 * compliance)
