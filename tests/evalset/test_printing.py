import itertools

import numpy as np
import pytest
import trimesh

from egad.evalset.printing import lie_down, pack, plan_prints

BED = (0.2, 0.2)


def boxes(count, seed=0):
    rng = np.random.default_rng(seed)
    return {
        f"box{number}": trimesh.creation.box(extents=rng.uniform(0.02, 0.08, 3))
        for number in range(count)
    }


def test_nothing_overlaps_and_nothing_leaves_the_bed():
    items = plan_prints(boxes(40), BED, gap=0.005)
    footprints = {}
    for label, item in items.items():
        low = np.array(item.place)
        high = low + item.mesh.extents[:2]
        assert (low >= 0.005 - 1e-9).all()
        assert (high <= 0.2 - 0.005 + 1e-9).all()
        footprints[label] = item.plate, low, high
    for (_, one), (_, other) in itertools.combinations(footprints.items(), 2):
        if one[0] == other[0]:
            gaps = np.maximum(other[1] - one[2], one[1] - other[2])
            assert gaps.max() >= 0.005 - 1e-9
    plates = {item.plate for item in items.values()}
    assert plates == set(range(1, len(plates) + 1))


def test_an_object_larger_than_the_bed_is_left_out_with_a_note():
    items = plan_prints(
        {"big": trimesh.creation.box(extents=(0.3, 0.25, 0.21)), **boxes(2)}, BED, 0
    )
    assert items["big"].plate is None
    assert "300 x 250 mm is larger than the bed of 200 x 200 mm" in items["big"].note
    assert items["box0"].plate == 1


def test_objects_lie_flat_on_the_bed():
    plank = trimesh.creation.box(extents=(0.01, 0.03, 0.1))
    plank.apply_transform(trimesh.transformations.rotation_matrix(0.5, [1, 2, 3], [0.4, 0, 0]))
    lying = lie_down(plank)
    assert lying.bounds[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert lying.extents == pytest.approx([0.1, 0.03, 0.01])
    assert lying.volume == pytest.approx(plank.volume)


def test_packing_is_the_same_every_time_and_in_any_order():
    sizes = {f"{n}": (0.03 + 0.001 * n, 0.05 - 0.001 * n) for n in range(30)}
    backwards = dict(reversed(sizes.items()))
    assert pack(sizes, BED, 0.002) == pack(backwards, BED, 0.002)
