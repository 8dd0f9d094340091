from egad.measures import MeasureSpace
from egad.report.space_map import shown_objects, space_map


def test_the_map_needs_pictures_of_the_objects_that_it_shows_only(objects, pictures):
    shown = shown_objects(objects)
    assert len(shown) < len(objects)
    few = {label: pictures[label] for label in shown}
    assert space_map(objects, few, MeasureSpace()) == space_map(objects, pictures, MeasureSpace())
