"""Objects as OpenUSD, for Isaac Sim, Isaac Lab and Newton: one rigid body in the frame of the mesh.

    /NAME                    RigidBodyAPI, MassAPI
    /NAME/visuals            instance of /Meshes/visuals: the true surface and its color
    /NAME/collisions         instance of /Meshes/collisions: convex hulls with friction

Units are metres and kilograms, and Z is up. Copies of an object share its meshes, because the
visuals and the collisions are instances. This module needs `usd-core`.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import trimesh
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.exchange.object_files import write_poses
from egad.geometry import MassProperties
from egad.io import GREY_LINEAR, ROUGHNESS
from egad.sim import SimulationObject

MESHES = Sdf.Path("/Meshes")  # abstract: not part of the scene
VISUALS, COLLISIONS = MESHES.AppendChild("visuals"), MESHES.AppendChild("collisions")


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `NAME.usd` (binary) and `poses.json`."""
    (folder / name).mkdir(parents=True)
    stage = make_stage(name, made, friction)
    for child in stage.GetDefaultPrim().GetChildren():
        child.SetInstanceable(True)
    save(stage, folder / name / f"{name}.usd")
    write_poses(folder / name, made)


def make_stage(name: str, made: SimulationObject, friction: float) -> Usd.Stage:
    """An object in memory, as the module describes it, but without instances."""
    stage = Usd.Stage.Open(Sdf.Layer.CreateAnonymous(".usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    path = Sdf.Path("/" + Tf.MakeValidIdentifier(name))
    body = UsdGeom.Xform.Define(stage, path if path != MESHES else Sdf.Path(f"{MESHES}_"))
    stage.SetDefaultPrim(body.GetPrim())
    Usd.ModelAPI(body).SetKind(Kind.Tokens.component)
    UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
    _add_mass(body, made.physics)
    stage.CreateClassPrim(MESHES)
    _define_visuals(stage, made.mesh)
    _define_collisions(stage, made.parts, friction)
    for child in (VISUALS, COLLISIONS):
        part = UsdGeom.Xform.Define(stage, body.GetPath().AppendChild(child.name)).GetPrim()
        part.GetReferences().AddInternalReference(child)
    return stage


def save(stage: Usd.Stage, path: Path) -> None:
    """Write a stage to a binary file whose name ends in `.usd`."""
    stage.GetRootLayer().Export(str(path), args={"format": "usdc"})


def principal_axes(inertia: Floats) -> tuple[Floats, Floats]:
    """Principal moments, (3,), ascending, and the quaternion (w, x, y, z) of their axes, w >= 0."""
    values, axes = np.linalg.eigh(inertia)
    largest = axes[np.abs(axes).argmax(axis=0), range(3)]
    axes = axes * np.sign(largest)  # LAPACK leaves the signs open
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # right-handed
    x, y, z, w = Rotation.from_matrix(axes).as_quat(canonical=True)
    return values, np.array([w, x, y, z])


def _add_mass(body: UsdGeom.Xform, physics: MassProperties) -> None:
    values, (w, x, y, z) = principal_axes(physics.inertia)
    mass = UsdPhysics.MassAPI.Apply(body.GetPrim())
    mass.CreateMassAttr(physics.mass)
    mass.CreateCenterOfMassAttr(Gf.Vec3f(*physics.com.tolist()))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*values.tolist()))
    mass.CreatePrincipalAxesAttr(Gf.Quatf(w, x, y, z))


def _define_visuals(stage: Usd.Stage, mesh: trimesh.Trimesh) -> None:
    UsdGeom.Xform.Define(stage, VISUALS)
    surface = _define_mesh(stage, VISUALS.AppendChild("surface"), mesh)
    material = UsdShade.Material.Define(stage, VISUALS.AppendChild("grey"))
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("preview"))
    shader.CreateIdAttr("UsdPreviewSurface")
    color = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.Set(Gf.Vec3f(*GREY_LINEAR))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(ROUGHNESS)
    output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    UsdShade.MaterialBindingAPI.Apply(surface.GetPrim()).Bind(material)


def _define_collisions(stage: Usd.Stage, parts: Iterable[trimesh.Trimesh], friction: float) -> None:
    """Convex parts, each bound to the material: USD's parser looks for it nowhere else."""
    UsdGeom.Xform.Define(stage, COLLISIONS).CreatePurposeAttr(UsdGeom.Tokens.guide)
    material = UsdShade.Material.Define(stage, COLLISIONS.AppendChild("material"))
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(friction)
    physics.CreateDynamicFrictionAttr(friction)
    physics.CreateRestitutionAttr(0.0)
    for number, part in enumerate(parts):
        path = COLLISIONS.AppendChild(f"part_{number:03d}")
        prim = _define_mesh(stage, path, part).GetPrim()
        UsdPhysics.CollisionAPI.Apply(prim)
        hull = UsdPhysics.MeshCollisionAPI.Apply(prim)
        hull.CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
        binding = UsdShade.MaterialBindingAPI.Apply(prim)
        binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")


def _define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: trimesh.Trimesh) -> UsdGeom.Mesh:
    """A triangle mesh with flat faces."""
    prim = UsdGeom.Mesh.Define(stage, path)
    points = Vt.Vec3fArray.FromNumpy(np.asarray(mesh.vertices, dtype=np.float32))
    corners = np.asarray(mesh.faces, dtype=np.int32)
    prim.CreatePointsAttr(points)
    prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(corners), 3, np.int32)))
    prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.ravel()))
    normals = np.repeat(np.asarray(mesh.face_normals, dtype=np.float32), 3, axis=0)
    prim.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals))
    prim.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    return prim
