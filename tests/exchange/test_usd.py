"""Objects as OpenUSD, read by OpenUSD itself."""

import numpy as np
import pytest
import trimesh

pxr = pytest.importorskip("pxr")
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation  # noqa: E402 (an extra)
from scipy.spatial.transform import Rotation  # noqa: E402

from egad.exchange.objects import usd  # noqa: E402


@pytest.fixture(scope="module")
def file(made, tmp_path_factory):
    folder = tmp_path_factory.mktemp("usd")
    usd.write(folder, "ell-1.x", made, 0.4)
    return str(folder / "ell-1.x/ell-1.x.usd")


@pytest.fixture(scope="module")
def stage(file):
    return Usd.Stage.Open(file)


def all_meshes(stage):
    """The meshes of the scene, those of instances too, by path."""
    prims = Usd.PrimRange(stage.GetDefaultPrim(), Usd.TraverseInstanceProxies())
    return {str(prim.GetPath()): UsdGeom.Mesh(prim) for prim in prims if prim.IsA(UsdGeom.Mesh)}


def surface_of(mesh):
    corners = np.reshape(mesh.GetFaceVertexIndicesAttr().Get(), (-1, 3))
    return trimesh.Trimesh(np.array(mesh.GetPointsAttr().Get()), corners)


def test_units_and_the_default_prim_are_set(stage):
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetDefaultPrim().GetName() == "ell_1_x"


def test_an_object_may_be_called_like_the_meshes(made, tmp_path):
    usd.write(tmp_path, "Meshes", made, 0.4)
    stage = Usd.Stage.Open(str(tmp_path / "Meshes/Meshes.usd"))
    assert not stage.GetDefaultPrim().IsAbstract()
    bodies, _ = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"])[UsdPhysics.ObjectType.RigidBody]
    assert bodies == [stage.GetDefaultPrim().GetPath()]


def test_the_validators_of_usd_have_no_complaint(file):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(file)) == []


def test_physics_has_one_body_with_a_hull_for_each_part(stage, made):
    """By the parser that engines use."""
    found = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"])
    kinds = UsdPhysics.ObjectType
    (body,) = found[kinds.RigidBody][1]
    assert len(body.collisions) == len(made.parts) == 2
    paths, shapes = found[kinds.MeshShape]
    assert {shape.approximation for shape in shapes} == {"convexHull"}
    assert {str(shape.rigidBody) for shape in shapes} == {"/ell_1_x"}
    (material,) = {str(path) for shape in shapes for path in shape.materials}
    (bound,) = [desc for path, desc in zip(*found[kinds.RigidBodyMaterial], strict=True)]
    assert material == "/ell_1_x/collisions/material"
    assert (bound.staticFriction, bound.dynamicFriction) == pytest.approx((0.4, 0.4))
    assert len(paths) == 2


def test_colliders_and_surface_are_those_of_the_object(stage, made):
    meshes = all_meshes(stage)
    surface = meshes.pop("/ell_1_x/visuals/surface")
    assert surface_of(surface).volume == pytest.approx(made.mesh.volume, rel=1e-5)
    assert surface.GetPurposeAttr().Get() == "default"
    for mesh, part in zip(meshes.values(), made.parts, strict=True):
        np.testing.assert_allclose(surface_of(mesh).bounds, part.bounds, atol=1e-7)
        assert UsdGeom.Imageable(mesh).ComputePurpose() == "guide"
    material, _ = UsdShade.MaterialBindingAPI(surface).ComputeBoundMaterial()
    assert material.ComputeSurfaceSource()[0].GetIdAttr().Get() == "UsdPreviewSurface"


def test_mass_properties_are_exact(stage, made):
    mass = UsdPhysics.MassAPI(stage.GetDefaultPrim())
    assert mass.GetMassAttr().Get() == pytest.approx(made.physics.mass, rel=1e-6)
    np.testing.assert_allclose(mass.GetCenterOfMassAttr().Get(), made.physics.com, rtol=1e-6)
    turn = mass.GetPrincipalAxesAttr().Get()
    axes = Rotation.from_quat([*turn.GetImaginary(), turn.GetReal()]).as_matrix()
    tensor = axes @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ axes.T
    largest = np.abs(made.physics.inertia).max()
    np.testing.assert_allclose(tensor, made.physics.inertia, atol=1e-6 * largest)


def test_copies_share_their_meshes(file):
    stage = Usd.Stage.CreateInMemory()
    for number in range(3):
        stage.DefinePrim(f"/copy_{number}").GetReferences().AddReference(file)
    assert len(stage.GetPrototypes()) == 2
    assert (
        len(UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"])[UsdPhysics.ObjectType.RigidBody][0])
        == 3
    )


@pytest.mark.parametrize("seed", range(5))
def test_principal_axes_give_the_tensor_back(seed):
    matrix = np.random.default_rng(seed).normal(size=(3, 3))
    tensor = matrix @ matrix.T
    values, (w, x, y, z) = usd.principal_axes(tensor)
    axes = Rotation.from_quat([x, y, z, w]).as_matrix()
    np.testing.assert_allclose(axes @ np.diag(values) @ axes.T, tensor, atol=1e-12)
    assert w >= 0
    assert (np.diff(values) >= 0).all()
