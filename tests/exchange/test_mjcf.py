"""Objects as MJCF in the scenes of others, which they neither change nor are changed by."""

import mujoco
import numpy as np
import pytest
import trimesh

from egad.exchange import write_simulation_object
from egad.exchange.objects import mjcf, robosuite
from egad.geometry import Bundle
from egad.sim import make_simulation_object

WRITERS = {
    "mjcf": mjcf.write,
    "robosuite": robosuite.write,
    "simulation": lambda folder, name, made, friction: write_simulation_object(
        folder / name, name, made, friction
    ),
}
INERTIAL = '<inertial pos="0 0 0" mass="0.56" diaginertia="0.002 0.004 0.002"/>'
DOOR = """<worldbody><body name="door">{inertial}
  <joint name="h" axis="0 0 1" range="0 {limit}" limited="true"/>
  <geom name="g" type="box" size=".1 .01 .1" density="700"/></body></worldbody>"""
COMPILERS = {
    "": 45,
    '<compiler angle="degree"/>': 45,
    '<compiler angle="radian"/>': 0.25 * np.pi,
    '<compiler angle="degree" inertiafromgeom="true" autolimits="false" eulerseq="zyx"/>': 45,
}
DEFAULTS = """<default>
  <mesh scale="0.001 0.001 0.001" inertia="convex" maxhullvert="4"/>
  <geom type="box" contype="0" conaffinity="4" condim="1" group="5" friction="2 2 2" density="9"
    rgba="1 0 0 1" solref="0.1 1" solimp="0 0 0 1 1" solmix="2" margin="0.01" gap="0.01"
    priority="3" pos="1 2 3" quat="0 1 0 0" fluidshape="ellipsoid"
    fluidcoef="1 1 1 1 1" shellinertia="true" fitscale="2"/>
  <joint damping="3" armature="2" stiffness="5"/><site rgba="1 1 1 1" size="9"/>
</default>"""
OF_BODIES = ("body_mass", "body_inertia", "body_ipos")
LOOK = ("group", "rgba")
SHAPE = ("type", "rbound", "pos", "quat")
CONTACT = ("contype", "conaffinity", "condim", "priority", "margin", "gap")
SOLVER = ("solref", "solimp", "solmix", "fluid")
OF_GEOMS = [f"geom_{name}" for name in (*LOOK, *SHAPE, *CONTACT, *SOLVER)]
OF_DOFS = ("dof_damping", "dof_armature")


@pytest.fixture(params=WRITERS)
def folder(request, made, tmp_path):
    """A folder with an object in it."""
    WRITERS[request.param](tmp_path, "ell", made, 0.4)
    return tmp_path


def compiled(folder, *sections):
    scene = folder / "scene.xml"
    scene.write_text(f"<mujoco>{''.join(sections)}</mujoco>")
    return mujoco.MjModel.from_xml_path(str(scene))


def values(model, bodies):
    """What the model says about bodies and all that belongs to them."""
    geoms, dofs = np.isin(model.geom_bodyid, bodies), np.isin(model.dof_bodyid, bodies)
    rows = {name: getattr(model, name)[bodies] for name in OF_BODIES}
    rows |= {name: getattr(model, name)[geoms] for name in OF_GEOMS}
    rows |= {name: getattr(model, name)[dofs] for name in OF_DOFS}
    return rows | {"geom_friction": model.geom_friction[geoms & (model.geom_contype > 0)]}


def assert_same(one, other, rtol=1e-9):
    for name, expected in other.items():
        near = {"rtol": rtol, "atol": rtol * 1e-3}
        np.testing.assert_allclose(one[name], expected, **near, err_msg=name)


def precision(compiler):
    """Relative; MuJoCo computes inertia from meshes in single precision."""
    return 1e-6 if "inertiafromgeom" in compiler else 1e-9


def object_bodies(model):
    return [number for number in range(1, model.nbody) if model.body(number).name != "door"]


@pytest.mark.parametrize("inertial", ["", INERTIAL])
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("defaults", ["", DEFAULTS])
def test_a_scene_and_an_object_in_it_are_as_they_are_alone(folder, compiler, inertial, defaults):
    limit = COMPILERS[compiler]
    scene = [compiler, defaults, DOOR.format(inertial=inertial, limit=limit)]
    alone = compiled(folder, *scene)
    door = values(alone, [alone.body("door").id])
    item = mujoco.MjModel.from_xml_path(str(folder / "ell/ell.xml"))
    include = '<include file="ell/ell.xml"/>'
    for number in range(len(scene) + 1):
        model = compiled(folder, *scene[:number], include, *scene[number:])
        np.testing.assert_allclose(model.joint("h").range, [0, 0.25 * np.pi])
        assert_same(values(model, [model.body("door").id]), door)
        found = values(model, object_bodies(model))
        assert_same(found, values(item, object_bodies(item)), precision(compiler))


@pytest.mark.parametrize("compiler", COMPILERS)
def test_an_object_can_be_attached(folder, made, compiler):
    limit = COMPILERS[compiler]
    door = DOOR.format(inertial="", limit=limit)
    scene = mujoco.MjSpec.from_string(f"<mujoco>{compiler}{DEFAULTS}{door}</mujoco>")
    alone = scene.compile()
    for prefix in ("one-", "two-"):
        item = mujoco.MjSpec.from_file(str(folder / "ell/ell.xml"))
        scene.worldbody.add_frame().attach_body(item.worldbody.first_body(), prefix, "")
    model = scene.compile()
    assert_same(values(model, [model.body("door").id]), values(alone, [alone.body("door").id]))
    mass = made.physics.mass
    assert model.body_mass.sum() - model.body("door").mass == pytest.approx(2 * mass, rel=1e-9)


def test_a_model_with_its_own_mesh_folder_attaches_an_object(made, tmp_path):
    mjcf.write(tmp_path, "ell", made, 0.4)
    model = compiled(
        tmp_path,
        '<compiler meshdir="elsewhere"/><asset><model name="ell" file="ell/ell.xml"/></asset>',
        '<worldbody><attach model="ell" body="ell" prefix="one-"/></worldbody>',
    )
    assert model.body("one-ell").mass == pytest.approx(made.physics.mass)


def test_mujoco_reads_a_solid_that_touches_itself_along_an_edge(tmp_path):
    cubes = [trimesh.creation.box((0.02,) * 3) for _ in range(2)]
    cubes[1].apply_translation((0.02, 0.02, 0))
    solid = trimesh.util.concatenate(cubes)
    solid.merge_vertices()
    made = make_simulation_object(solid, 400.0, Bundle())
    mjcf.write(tmp_path, "cubes", made, 0.4)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "cubes/cubes.xml"))
    assert model.body_mass[1] == pytest.approx(2 * 0.02**3 * 400)
