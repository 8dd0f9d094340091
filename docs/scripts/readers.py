"""Third-party readers, tried on exported objects.

    python docs/scripts/readers.py EXPORTS BUNDLE [READER ...]

EXPORTS has a folder for each format, such as `usd`, made by `egad export --format usd`. BUNDLE is
the folder of the simulation bundle that they were made from. The script needs only the readers, and
may run in an environment of its own. Readers that are not installed are left out; if any are named,
only those run:

    pip install drake mujoco mujoco-warp 'newton[importers]' omniverse-asset-validator pandas
    pip install pyarrow pybullet pygltflib robosuite sapien scipy trimesh
    pip install simready-foundation-tier-core simready-validate
    pip install bpy
    npm install gltf-validator

It prints a table of what each reader says about all objects, which `docs/exchange.md` sums up.
"""

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

Row = dict[str, Any]
DROP = 0.01  # m, above the table
SECONDS = 2.0
SAME_POSE = 5.0  # degrees
KHRONOS = """
const fs = require('fs'), validator = require('gltf-validator');
(async () => {
  const found = { errors: 0, warnings: 0, infos: 0, hints: 0, version: validator.version() };
  for (const file of process.argv.slice(1)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    found.errors += report.issues.numErrors; found.warnings += report.issues.numWarnings;
    found.infos += report.issues.numInfos; found.hints += report.issues.numHints;
  }
  console.log(JSON.stringify(found));
})();
"""


def tensor(row: Row) -> np.ndarray:
    """The inertia of an object about its center of mass, (3, 3)."""
    xx, yy, zz, xy, xz, yz = (
        row[f"inertia_{axes}"] for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class Errors:
    """The largest relative errors over all objects, and how many were read."""

    def __init__(self) -> None:
        self.read, self.mass, self.inertia, self.center = 0, 0.0, 0.0, 0.0
        self.frictions: set[float] = set()
        self.parts = 0

    def add(
        self,
        row: Row,
        mass: float,
        moments: Any,  # noqa: ANN401 (3 numbers of any kind)
        center: Any = None,  # noqa: ANN401
        parts: int = 0,
    ) -> None:
        """Compare an object with its row.

        Args:
            row: Row of the table of the bundle.
            mass: As read, kg.
            moments: Principal moments as read, kg m2.
            center: Center of mass as read, m.
            parts: Number of colliders.
        """
        self.read += 1
        self.mass = max(self.mass, abs(mass / row["mass"] - 1))
        expected = np.linalg.eigvalsh(tensor(row))
        off = np.abs(np.sort(np.asarray(moments, float)) / expected - 1).max()
        self.inertia = max(self.inertia, float(off))
        if center is not None:
            known = np.array([row["com_x"], row["com_y"], row["com_z"]])
            self.center = max(self.center, float(np.abs(np.asarray(center) - known).max()))
        if parts != row["parts"]:
            raise ValueError(f"{row['label']}: {parts} colliders, {row['parts']} parts")
        self.parts += parts

    def __str__(self) -> str:
        friction = ", ".join(f"{value:g}" for value in sorted(self.frictions)) or "not read"
        return (
            f"{self.read} objects, {self.parts} colliders; mass off by {self.mass:.0e}, inertia by"
            f" {self.inertia:.0e}, center of mass by {self.center:.0e} m; friction {friction}"
        )


def validated_usd(exports: Path, rows: list[Row]) -> str:
    """The validator of Omniverse with all its rules."""
    from omni.asset_validator import ValidationEngine

    engine = ValidationEngine()
    issues = [
        str(issue)
        for row in rows
        for issue in engine.validate(
            str(exports / "usd" / row["label"] / f"{row['label']}.usd")
        ).issues()
    ]
    return f"{len(rows)} objects, {len(issues)} issues{': ' + issues[0] if issues else ''}"


def validated_simready(exports: Path, rows: list[Row]) -> str:
    """NVIDIA's rules for props: the features that its profile requires, and that of grasps."""
    import simready.validate as rules

    rules.initialize([], [], [])
    failed: set[str] = set()
    for row in rows:
        file = exports / "simready" / row["label"] / "simready" / f"{row['label']}.usd"
        config = rules.AssetValidationConfig(
            asset_path=str(file), profile_id="Robotics-Prop", profile_version="4.0.0"
        )
        found = rules.validate_asset(config).features_summary
        if not found["FET_005_STANDARD"]["passed"]:
            failed.add(f"{row['label']}: FET_005_STANDARD")
        failed |= {
            f"{row['label']}: {name}"
            for name, feature in found.items()
            if feature["blocking_failure"]
        }
    return (
        f"{len(rows)} props, {len(failed)} features failed {', '.join(sorted(failed)[:5])}".strip()
    )


def newton_usd(exports: Path, rows: list[Row], bundle: Path) -> str:
    """Newton: colliders, mass and inertia, and a drop near the most probable pose."""
    import newton

    errors, rested = Errors(), 0
    for row in rows:
        builder = newton.ModelBuilder()
        builder.add_usd(str(exports / "usd" / row["label"] / f"{row['label']}.usd"))
        solid = [kind for kind in builder.shape_type if kind == newton.GeoType.CONVEX_MESH]
        moments = np.linalg.eigvalsh(np.array(builder.body_inertia[0], float).reshape(3, 3))
        errors.add(row, builder.body_mass[0], moments, builder.body_com[0], len(solid))
        colliders = np.array(builder.shape_type) == newton.GeoType.CONVEX_MESH
        errors.frictions |= set(np.round(np.array(builder.shape_material_mu)[colliders], 6))
        rested += rests_in_newton(builder, row, bundle)
    return f"{errors}; {rested} of {len(rows)} lie in a listed pose {SECONDS:g} s after a drop"


def rests_in_newton(builder: Any, row: Row, bundle: Path) -> bool:  # noqa: ANN401 (of newton)
    """Whether an object that falls from 1 cm in its most probable pose ends in a listed one."""
    import newton
    import warp as wp

    poses = json.loads((bundle / row["label"] / "poses.json").read_text())
    matrix = np.array(poses[0]["transform"])
    builder.add_ground_plane()
    place = [*(matrix[:3, 3] + [0, 0, DROP]), *Rotation.from_matrix(matrix[:3, :3]).as_quat()]
    builder.body_q[0] = wp.transform(*place)
    builder.joint_q[:7] = place
    model = builder.finalize()
    solver = newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True, njmax=2000, nconmax=1000)
    state, after, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    step = 0.002
    for _ in range(int(SECONDS / step)):
        state.clear_forces()
        solver.step(state, after, control, None, step)
        state, after = after, state
    turn = Rotation.from_quat(state.body_q.numpy()[0][3:])
    return is_listed(poses, turn.as_matrix())


def is_listed(poses: list[Row], turn: np.ndarray) -> bool:
    """Whether an orientation is within 5 degrees of that of a listed pose."""
    normals = np.array([pose["face_normal"] for pose in poses])
    cosines = normals @ (turn.T @ [0, 0, -1])
    return bool(cosines.max() > np.cos(np.radians(SAME_POSE)))


def in_drake(exports: Path, rows: list[Row], style: str, file: str) -> str:
    """Drake's parser: bodies, colliders, mass, inertia, friction."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    errors, shapes = Errors(), set()
    for row in rows:
        builder = DiagramBuilder()
        plant, scene = AddMultibodyPlantSceneGraph(builder, 0.001)
        path = exports / style / row["label"] / file.format(row["label"])
        (model,) = Parser(plant).AddModels(str(path))
        plant.Finalize()
        body = plant.get_body(plant.GetBodyIndices(model)[0])
        inertia = body.default_spatial_inertia()
        center = inertia.get_com()
        about = inertia.Shift(center).CalcRotationalInertia().CopyToFullMatrix3()
        geometries = plant.GetCollisionGeometriesForBody(body)
        errors.add(row, body.default_mass(), np.linalg.eigvalsh(about), center, len(geometries))
        inspector = scene.model_inspector()
        for each in geometries:
            friction = inspector.GetProximityProperties(each).GetProperty(
                "material", "coulomb_friction"
            )
            errors.frictions |= {friction.static_friction(), friction.dynamic_friction()}
            shapes.add(type(inspector.GetShape(each)).__name__)
    return f"{errors}; colliders are {', '.join(sorted(shapes))}"


def in_mujoco(exports: Path, rows: list[Row]) -> str:
    """MuJoCo on MJCF."""
    import mujoco

    errors = Errors()
    for row in rows:
        path = exports / "mjcf" / row["label"] / f"{row['label']}.xml"
        add_mujoco(errors, row, mujoco.MjModel.from_xml_path(str(path)), 1)
    return str(errors)


def add_mujoco(errors: Errors, row: Row, model: Any, body: int) -> None:  # noqa: ANN401
    """Compare a body of a MuJoCo model."""
    collides = (model.geom_bodyid == body) & (model.geom_contype > 0)
    errors.add(
        row,
        model.body_mass[body],
        model.body_inertia[body],
        model.body_ipos[body],
        int(collides.sum()),
    )
    errors.frictions |= set(np.round(model.geom_friction[collides, 0], 9))


def in_robosuite(exports: Path, rows: list[Row]) -> str:
    """The object class of robosuite, in a world of its own, compiled by MuJoCo."""
    import mujoco
    from robosuite.models import MujocoWorldBase
    from robosuite.models.arenas import EmptyArena
    from robosuite.models.objects import MujocoXMLObject

    errors = Errors()
    for row in rows:
        path = exports / "robosuite" / row["label"] / f"{row['label']}.xml"
        made = MujocoXMLObject(
            str(path), name="thing", joints=[{"type": "free"}], duplicate_collision_geoms=False
        )
        if not made.bottom_offset[2] < made.top_offset[2] or made.horizontal_radius <= 0:
            raise ValueError(f"{row['label']}: its sites are wrong")
        world = MujocoWorldBase()
        world.merge(EmptyArena())
        world.merge_assets(made)
        world.worldbody.append(made.get_obj())
        model = mujoco.MjModel.from_xml_string(world.get_xml())
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, made.root_body)
        add_mujoco(errors, row, model, body)
    return str(errors)


def in_pybullet(exports: Path, rows: list[Row]) -> str:
    """PyBullet on URDF."""
    import pybullet

    errors = Errors()
    pybullet.connect(pybullet.DIRECT)
    for row in rows:
        path = exports / "urdf" / row["label"] / f"{row['label']}.urdf"
        body = pybullet.loadURDF(str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        info = pybullet.getDynamicsInfo(body, -1)
        parts = len(pybullet.getCollisionShapeData(body, -1))
        errors.add(row, info[0], info[2], info[3], parts)
        errors.frictions.add(info[1])
        pybullet.removeBody(body)
    pybullet.disconnect()
    return str(errors)


def in_sapien(exports: Path, rows: list[Row]) -> str:
    """SAPIEN on URDF, on the CPU: colliders, mass, and how far its hulls are from the parts."""
    import sapien

    errors, off = Errors(), []
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    for row in rows:
        folder = exports / "urdf" / row["label"]
        found = scene.create_urdf_loader().parse(str(folder / f"{row['label']}.urdf"))
        (builder,) = found[1] or found[0][0].link_builders
        builder.visual_records.clear()  # they need a renderer
        entity = builder.build(name=row["label"])
        body = entity.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
        shapes = body.collision_shapes
        errors.add(row, body.mass, body.inertia, body.cmass_local_pose.p, len(shapes))
        for number, shape in enumerate(shapes):
            corners = shape.scale * vertices_of(folder / f"parts/part-{number:03d}.obj")
            planes = ConvexHull(shape.scale * shape.vertices).equations
            off.append((planes[:, :3] @ corners.T + planes[:, 3:]).max())
    return (
        f"{errors}; corners of parts at most {1000 * max(off):.2f} mm outside the hull, median"
        f" {1000 * np.median(off):.4f} mm"
    )


def vertices_of(path: Path) -> np.ndarray:
    """The vertices of an OBJ file, (n, 3)."""
    lines = path.read_text().splitlines()
    return np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)


def glb_in_trimesh(exports: Path, rows: list[Row], bundle: Path) -> str:
    """The surface of the GLB turned from Y up to Z up is the visual mesh."""
    import trimesh

    off = 0.0
    for row in rows:
        scene = trimesh.load_scene(exports / "glb" / f"{row['label']}.glb")
        turned = scene.to_geometry().apply_transform(
            trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
        )
        known = trimesh.load_mesh(bundle / row["label"] / "visual.obj")
        off = max(off, float(np.abs(turned.triangles - known.triangles).max()))
        if not turned.is_volume:
            raise ValueError(f"{row['label']}: its surface is open")
    return f"{len(rows)} objects, closed; vertices off by {off:.0e} m"


def glb_in_blender(exports: Path, rows: list[Row], bundle: Path) -> str:
    """What Blender imports has the bounds of the visual mesh: it lies in the same frame."""
    import bpy

    off = 0.0
    for row in rows:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.import_scene.gltf(filepath=str(exports / "glb" / f"{row['label']}.glb"))
        (found,) = [each for each in bpy.context.scene.objects if each.type == "MESH"]
        turn = np.array(found.matrix_world)
        corners = np.array([each.co for each in found.data.vertices]) @ turn[:3, :3].T + turn[:3, 3]
        known = vertices_of(bundle / row["label"] / "visual.obj")
        for side in (np.min, np.max):
            off = max(off, float(np.abs(side(corners, axis=0) - side(known, axis=0)).max()))
    return f"{len(rows)} objects; bounds off by {off:.0e} m"


def glb_in_pygltflib(exports: Path, rows: list[Row]) -> str:
    """One mesh with one material in each file."""
    from pygltflib import GLTF2

    for row in rows:
        found = GLTF2().load(str(exports / "glb" / f"{row['label']}.glb"))
        if not len(found.meshes) == len(found.materials) == len(found.nodes) == 1:
            raise ValueError(f"{row['label']}: not one mesh with one material")
    return f"{len(rows)} objects, each one mesh with one metallic-roughness material"


def khronos(exports: Path, rows: list[Row]) -> tuple[str, str]:
    """The validator of Khronos: its version, and the issues of all files."""
    files = [str(exports / "glb" / f"{row['label']}.glb") for row in rows]
    done = subprocess.run(
        ["node", "-e", KHRONOS, "--", *files], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    counts = ", ".join(f"{found[kind]} {kind}" for kind in ("errors", "warnings", "infos", "hints"))
    return found["version"], f"{len(rows)} objects, {counts}"


def results(
    exports: Path, bundle: Path, rows: list[Row], names: list[str]
) -> Iterator[tuple[str, str, str, str]]:
    """Format, reader, version and result of every reader that is installed."""
    tries: list[tuple[str, str, str, Callable[[], str]]] = [
        (
            "usd",
            "omniverse-asset-validator",
            "omni.asset_validator",
            lambda: validated_usd(exports, rows),
        ),
        (
            "simready",
            "simready-validate",
            "simready.validate",
            lambda: validated_simready(exports, rows),
        ),
        ("usd", "newton", "newton", lambda: newton_usd(exports, rows, bundle)),
        ("sdf", "drake", "pydrake", lambda: in_drake(exports, rows, "sdf", "model.sdf")),
        ("urdf", "drake", "pydrake", lambda: in_drake(exports, rows, "urdf", "{}.urdf")),
        ("mjcf", "drake", "pydrake", lambda: in_drake(exports, rows, "mjcf", "{}.xml")),
        ("urdf", "pybullet", "pybullet", lambda: in_pybullet(exports, rows)),
        ("urdf", "sapien", "sapien", lambda: in_sapien(exports, rows)),
        ("mjcf", "mujoco", "mujoco", lambda: in_mujoco(exports, rows)),
        ("robosuite", "robosuite", "robosuite", lambda: in_robosuite(exports, rows)),
        ("glb", "trimesh", "trimesh", lambda: glb_in_trimesh(exports, rows, bundle)),
        ("glb", "bpy", "bpy", lambda: glb_in_blender(exports, rows, bundle)),
        ("glb", "pygltflib", "pygltflib", lambda: glb_in_pygltflib(exports, rows)),
    ]
    for style, package, module, run in tries:
        installed = importlib.util.find_spec(module.partition(".")[0]) is not None
        if installed and package in (names or [package]) and (exports / style).is_dir():
            yield style, package, version(package), run()
    if (exports / "glb").is_dir() and "gltf-validator" in (names or ["gltf-validator"]):
        yield "glb", "gltf-validator", *khronos(exports, rows)


def main() -> None:
    """Print the table, a row as soon as its reader is done."""
    exports, bundle = map(Path, sys.argv[1:3])
    rows = pd.read_parquet(bundle / "bundle.parquet").to_dict("records")
    print("| format | reader | version | result |\n| --- | --- | --- | --- |")
    for line in results(exports, bundle, rows, sys.argv[3:]):
        print(f"| {' | '.join(line)} |", flush=True)


if __name__ == "__main__":
    main()
