import itertools

import numpy as np
import pytest
import trimesh

from egad.evalset import PrintCheck, PrintExport
from egad.evalset.plates import pack, plan_prints
from egad.evalset.print_poses import first_layer_area, lie_down, overhang_area

CHECK = PrintCheck()
BEDS = [(0.2, 0.2), (0.22, 0.22), (0.256, 0.256)]


def boxes(count, seed=0):
    rng = np.random.default_rng(seed)
    return {
        f"box{number}": trimesh.creation.box(extents=rng.uniform(0.02, 0.08, 3))
        for number in range(count)
    }


def planned(meshes, bed=BEDS[0], gap=0.005):
    return plan_prints(meshes, PrintExport(bed=bed, gap=gap), CHECK)


@pytest.mark.parametrize("bed", BEDS)
def test_nothing_overlaps_and_nothing_leaves_the_bed(bed):
    rng = np.random.default_rng(1)
    sizes = {f"{n}": tuple(rng.uniform(0.02, 0.09, 2)) for n in range(60)}
    places = pack(sizes, bed, 0.005)
    boxes_of = {
        label: (plate, np.array(at), sizes[label]) for label, (plate, *at) in places.items()
    }
    assert set(boxes_of) == set(sizes)
    for _, low, size in boxes_of.values():
        assert (low >= 0.005 - 1e-9).all()
        assert (low + size <= np.array(bed) - 0.005 + 1e-9).all()
    for one, other in itertools.combinations(boxes_of.values(), 2):
        if one[0] == other[0]:
            gaps = np.maximum(other[1] - one[1] - one[2], one[1] - other[1] - other[2])
            assert gaps.max() >= 0.005 - 1e-9
    plates = {plate for plate, _, _ in boxes_of.values()}
    assert plates == set(range(1, len(plates) + 1))
    area = sum(width * depth for width, depth in sizes.values())
    assert len(plates) <= 2 * area / (bed[0] * bed[1]) + 1


CORNERS = [(0.018, 0.028), (0.1, 0.01), (0.05, 0.12), (0.0, 0.0), (0.03, 0.0)]


@pytest.mark.parametrize("corner", CORNERS)
def test_nothing_is_in_the_corner_to_keep_out_of(corner):
    bed, gap = (0.256, 0.256), 0.005
    rng = np.random.default_rng(2)
    sizes = {f"{n}": tuple(rng.uniform(0.01, 0.09, 2)) for n in range(80)}
    sizes |= {"wide": (0.24, 0.05), "deep": (0.05, 0.24)}  # the one behind it, the other beside it
    places = pack(sizes, bed, gap, corner)
    assert set(places) == {
        label
        for label, (width, depth) in sizes.items()
        if width + corner[0] + 2 * gap <= bed[0] or depth + corner[1] + 2 * gap <= bed[1]
    }
    taken = [(plate, x, y, *sizes[label]) for label, (plate, x, y) in places.items()]
    if all(corner):
        taken += [(plate, 0, 0, *corner) for plate in {each[0] for each in taken}]
    for one, other in itertools.combinations(taken, 2):
        overlaps = [
            min(one[low] + one[low + 2], other[low] + other[low + 2]) - max(one[low], other[low])
            for low in (1, 2)
        ]
        assert one[0] != other[0] or min(overlaps) <= -gap + 1e-9
    for _, x, y, width, depth in taken:
        assert x + width <= bed[0] + 1e-9
        assert y + depth <= bed[1] + 1e-9
    if not all(corner):
        assert places == pack(sizes, bed, gap)


def test_an_object_that_the_corner_leaves_no_room_for_has_a_note():
    settings = PrintExport(bed=(0.1, 0.1), keep_out=(0.05, 0.05))
    meshes = {"big": trimesh.creation.box(extents=(0.08, 0.08, 0.05)), **boxes(1)}
    items = plan_prints(meshes, settings, CHECK)
    assert items["big"].note.endswith("the bed of 100 x 100 mm with its corner to keep out of")


def test_an_object_larger_than_the_bed_is_left_out_with_a_note():
    big = trimesh.creation.box(extents=(0.09, 0.075, 0.063))
    items = planned({"big": big, **boxes(2)}, (0.06, 0.06), gap=0)
    assert items["big"].plate is None
    assert "do not fit the bed of 60 x 60 mm" in items["big"].note
    assert items["box0"].plate == 1


@pytest.mark.parametrize("bed", [(0.1, 0.25), (0.25, 0.1)])
def test_a_long_object_lies_along_the_longer_side_of_the_bed(bed):
    item = planned({"bar": trimesh.creation.box(extents=(0.2, 0.05, 0.03))}, bed)["bar"]
    assert item.plate == 1
    assert item.pose.mesh.extents[int(np.argmax(bed))] == pytest.approx(0.2)


def test_objects_lie_flat_on_the_bed():
    plank = trimesh.creation.box(extents=(0.01, 0.03, 0.1))
    plank.apply_transform(trimesh.transformations.rotation_matrix(0.5, [1, 2, 3], [0.4, 0, 0]))
    lying = lie_down(plank, "stable")
    assert lying.mesh.bounds[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert lying.mesh.extents == pytest.approx([0.1, 0.03, 0.01])
    assert lying.mesh.volume == pytest.approx(plank.volume)
    assert lying.contact == pytest.approx(0.003)
    assert lying.overhang == 0


def test_the_least_overhanging_pose_may_be_another_than_the_most_stable():
    """A low table: only on its top it needs no support."""
    parts = [trimesh.creation.box(extents=(0.08, 0.08, 0.01))]
    for x, y in itertools.product((-0.03, 0.03), repeat=2):
        leg = trimesh.creation.box(extents=(0.01, 0.01, 0.03))
        parts.append(leg.apply_translation([x, y, -0.015]))
    table = trimesh.boolean.union(parts, engine="manifold")
    best = lie_down(table, "overhang")
    assert best.overhang == pytest.approx(0, abs=1e-9)
    assert best.contact == pytest.approx(0.0064, rel=1e-6)
    standing = overhang_area(table, np.eye(3), 40)
    assert standing == pytest.approx(0.0064 - 4 * 0.0001, rel=1e-6)
    assert first_layer_area(table, np.eye(3)) == pytest.approx(0.0004, rel=1e-4)
    assert lie_down(table, "stable").probability >= best.probability


def test_a_pose_has_a_first_layer_that_slicers_print(released_set):
    """In the pose with the least overhang, D4 stands on 0.2 mm2."""
    assert lie_down(released_set["D4"], "overhang").contact >= 1e-6


def test_surface_counts_as_overhang_from_the_angle_on():
    cone = trimesh.creation.cone(radius=0.01, height=0.01, sections=64)  # 45 degrees
    upside_down = np.diag([1.0, -1, -1])
    assert overhang_area(cone, upside_down, 40) == pytest.approx(np.pi * 2**0.5 * 1e-4, rel=0.01)
    assert overhang_area(cone, upside_down, 50) == 0
    assert overhang_area(cone, np.eye(3), 40) == 0


def test_packing_is_the_same_every_time_and_in_any_order():
    sizes = {f"{n}": (0.03 + 0.001 * n, 0.05 - 0.001 * n) for n in range(30)}
    backwards = dict(reversed(sizes.items()))
    assert pack(sizes, BEDS[0], 0.002) == pack(backwards, BEDS[0], 0.002)
