"""Volumes that slicers do not print: project files as these programs write them."""

import numpy as np
import pytest
import trimesh
from mesh_files import CORE, assembly, model, package, solid_xml

from egad.errors import RejectedError
from egad.io import read_mesh

PRUSA = "Metadata/Slic3r_PE_model.config"
BAMBU = "Metadata/model_settings.config"
MOVED = "0 1 0 -1 0 0 0 0 1 100 50 10"


def box(side, center=(0, 0, 0)):
    return trimesh.creation.box((side,) * 3, trimesh.transformations.translation_matrix(center))


CUBE, LARGE = box(20), box(60)
CORNER = box(10, (10, 10, 10))  # an eighth of it is in the cube
CORNERED = 20**3 - 5**3


def joined_xml(number, *meshes, more=""):
    """One mesh object of several volumes, one after the other."""
    mesh = trimesh.util.concatenate(meshes)
    xml = solid_xml(number, mesh.vertices, mesh.faces)
    return xml.replace("</mesh>", f"{more}</mesh>")


def prusa(*volumes, number=1):
    """How PrusaSlicer describes an object of volumes of 12 triangles each."""
    rows = "".join(
        f'<volume firstid="{12 * k}" lastid="{12 * k + 11}">'
        f'<metadata type="volume" key="name" value="x"/>{metadata}</volume>'
        for k, metadata in enumerate(volumes)
    )
    return f'<object id="{number}" instances_count="1">{rows}</object>'


def kind(name):
    return f'<metadata type="volume" key="volume_type" value="{name}"/>'


def config(*objects):
    return f'<?xml version="1.0" encoding="UTF-8"?><config>{"".join(objects)}</config>'


def read(folder, text, settings="", where=PRUSA, others=None):
    data = package(text, others={**(others or {}), **({where: settings} if settings else {})})
    (folder / "project.3mf").write_bytes(data)
    return read_mesh(folder / "project.3mf", None)


def assert_size(mesh, side, volume):
    assert mesh.is_watertight
    assert 1000 * mesh.extents == pytest.approx(np.broadcast_to(side, 3))
    assert 1e9 * mesh.volume == pytest.approx(volume)


NOT_SOLID = [
    kind("ParameterModifier"),
    kind("SupportBlocker"),
    kind("SupportEnforcer"),
    '<metadata type="volume" key="modifier" value="1"/>',
    '<metadata type="volume" key="modifier" value="1"/>' + kind("SupportBlocker"),
]


@pytest.mark.parametrize("what", NOT_SOLID)
@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("where", [PRUSA, "Metadata/SuperSlicer_model.config"])
def test_volumes_that_only_change_settings_are_left_out(tmp_path, what, first, where):
    meshes, kinds = (CUBE, LARGE), (kind("ModelPart"), what)
    if not first:
        meshes, kinds = meshes[::-1], kinds[::-1]
    text = model(joined_xml(1, *meshes))
    assert_size(read(tmp_path, text, config(prusa(*kinds)), where), 20, 8000)


def test_slic3r_notes_volumes_within_the_mesh(tmp_path):
    space = "http://schemas.slic3r.org/3mf/2017/06"
    more = (
        '<slic3r:volumes><slic3r:volume ts="0" te="11" modifier="0" ></slic3r:volume>'
        '<slic3r:volume ts="12" te="23" modifier="1" ></slic3r:volume></slic3r:volumes>'
    )
    text = model(joined_xml(1, CUBE, LARGE, more=more), head=f' xmlns:slic3r="{space}"')
    assert_size(read(tmp_path, text), 20, 8000)


@pytest.mark.parametrize("inside_out", [False, True])
def test_negative_volumes_are_cut_out_of_each_instance(tmp_path, inside_out):
    hole = CORNER.copy()
    if inside_out:
        hole.invert()
    text = model(
        joined_xml(1, CUBE, hole) + assembly(2, 'objectid="1"'),
        [f'objectid="1" transform="{MOVED}"', 'objectid="2"'],
    )
    mesh = read(tmp_path, text, config(prusa(kind("ModelPart"), kind("NegativeVolume"))))
    assert_size(mesh, (120, 70, 30), 2 * CORNERED)


def test_a_negative_volume_does_not_reach_into_other_objects(tmp_path):
    text = model(
        joined_xml(1, CUBE, box(60, (40, 0, 0))) + joined_xml(2, box(20, (40, 0, 0))),
        ['objectid="1"', 'objectid="2"'],
    )
    settings = config(prusa(kind("ModelPart"), kind("NegativeVolume")), prusa("", number=2))
    assert_size(read(tmp_path, text, settings), (60, 20, 20), 16_000)


def test_nothing_may_be_left(tmp_path):
    text = model(joined_xml(1, CUBE, LARGE))
    with pytest.raises(RejectedError, match="no faces"):
        read(tmp_path, text, config(prusa(kind("ModelPart"), kind("NegativeVolume"))))
    with pytest.raises(RejectedError, match="SupportBlocker"):
        read(tmp_path, text, config(prusa(kind("SupportBlocker"), kind("SupportBlocker"))))


def test_nothing_is_cut_out_of_an_open_surface(tmp_path):
    torn = CUBE.submesh([range(11)], append=True)
    text = model(joined_xml(1, CORNER, torn))
    with pytest.raises(RejectedError, match=r"negative volume.* no solid"):
        settings = prusa(kind("NegativeVolume"), "").replace('"23"', '"22"')
        read(tmp_path, text, config(settings))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('"23"', '"24"', "do not fit the 24 triangles"),
        ('"23"', '"22"', "do not fit"),
        ('"12"', '"11"', "do not fit"),
        ('"0" lastid="11"', '"-12" lastid="11"', "do not fit"),
        ('"11"', '"many"', "no range"),
        ("SupportBlocker", "WipeTower", "'WipeTower', which is not supported"),
    ],
)
def test_volumes_that_do_not_fit_are_refused_unless_all_are_solid(tmp_path, old, new, reason):
    settings = config(prusa(kind("ModelPart"), kind("SupportBlocker"))).replace(old, new)
    text = model(joined_xml(1, CUBE, box(20, (40, 0, 0))))
    with pytest.raises(RejectedError, match=reason):
        read(tmp_path, text, settings)
    if old != "SupportBlocker":
        solid = settings.replace("SupportBlocker", "ModelPart")
        assert_size(read(tmp_path, text, solid), (60, 20, 20), 16_000)


def bambu(number, *parts):
    rows = "".join(f'<part id="{part}" subtype="{name}"></part>' for part, name in parts)
    return f'<object id="{number}"><metadata key="name" value="x"/>{rows}</object>'


def in_parts(*meshes, kinds):
    """Objects 1, 2, ... of a part of the file; Bambu Studio writes all but solids as `other`."""
    return model(
        "".join(
            solid_xml(k, mesh.vertices, mesh.faces, kind=f' type="{name}"')
            for k, (mesh, name) in enumerate(zip(meshes, kinds, strict=True), 1)
        ),
        [],
    )


OBJECTS = "3D/Objects/object_1.model"


def components(*numbers, more=""):
    return [f'p:path="/{OBJECTS}" objectid="{number}"{more}' for number in numbers]


@pytest.mark.parametrize("usual", ["model", "other"])
@pytest.mark.parametrize(
    ("name", "volume"),
    [
        ("modifier_part", 8000),
        ("support_blocker", 8000),
        ("support_enforcer", 8000),
        ("negative_part", CORNERED),
    ],
)
def test_parts_of_bambu_studio(tmp_path, usual, name, volume):
    parts = in_parts(CUBE, CORNER, kinds=("model", usual))
    mesh = read(
        tmp_path,
        model(assembly(4, *components(1, 2)), [f'objectid="4" transform="{MOVED}"']),
        config(bambu(4, (1, "normal_part"), (2, name)), "<plate><metadata/></plate>"),
        BAMBU,
        {OBJECTS: parts},
    )
    assert_size(mesh, 20, volume)


def test_parts_that_share_a_mesh(tmp_path):
    """The same mesh twice: the first solid, the second cut out of it, moved by half a side."""
    moved = components(1, more=' transform="1 0 0 0 1 0 0 0 1 10 0 0"')
    mesh = read(
        tmp_path,
        model(assembly(4, *components(1), *moved), ['objectid="4"']),
        config(bambu(4, (1, "normal_part"), (1, "negative_part"))),
        BAMBU,
        {OBJECTS: in_parts(CUBE, kinds=("model",))},
    )
    assert_size(mesh, (10, 20, 20), 4000)


@pytest.mark.parametrize(
    "name", ["infill_mesh", "cutting_mesh", "support_mesh", "anti_overhang_mesh"]
)
@pytest.mark.parametrize(("prefix", "yes"), [("cura:", "True"), ("", "True"), ("cura:", "true")])
def test_objects_that_cura_does_not_print(tmp_path, name, prefix, yes):
    def noted(value):
        entry = f'<metadata name="{prefix}{name}" type="xs:string">{value}</metadata>'
        return f'<metadatagroup xmlns="{CORE}">{entry}</metadatagroup><mesh>'

    text = model(
        joined_xml(1, CUBE).replace("<mesh>", noted("False"))
        + joined_xml(2, LARGE).replace("<mesh>", noted(yes)),
        ['objectid="1"', 'objectid="2"'],
    )
    assert_size(read(tmp_path, text), 20, 8000)
