from egad.random import entropy, generator


def test_streams_are_fixed_and_distinct():
    assert entropy(0, "regrade", "abc") == 252684767072862689929908977155073498352
    names = [(0, "a"), (1, "a"), (0, "b"), (0, "a", 0), (0, "a", 1), (0, "a", 0, 1), (0, "a", 1, 0)]
    assert len({entropy(*name) for name in names}) == len(names)


def test_numbers_and_texts_do_not_run_together():
    assert entropy(0, "a", 1, 23) != entropy(0, "a", 12, 3)


def test_generators_repeat():
    first, second = (generator(7, "grasps", 3).random(4).tolist() for _ in range(2))
    assert first == second
    assert first != generator(7, "grasps", 4).random(4).tolist()
