"""Functions: training sets, and the networks trained on them and tested. No rules here."""


def settings_of_set(stage):
    """The settings of a stage for a training set and, if the wildcards have a seed, a network."""
    return lambda wildcards: _as_json(
        select(_settings_of_set(wildcards), settings_type(stage_function(stage)), GRIPPER)
    )


def _settings_of_set(wildcards):
    network = training_study.Network(wildcards.training_set, int(wildcards.get("seed", 0)))
    return training_study.settings_for(SETTINGS, network)


def settings_of_test(stage):
    """The same for a detector that is tested, with the noise in the file name."""
    return lambda wildcards: _as_json(_settings_of_test(stage, wildcards))


def settings_of_test_with_keep_going(stage):
    """The same, with `keep_going`, as `settings_with_keep_going`."""
    return lambda wildcards, input: _settings_of_test(stage, wildcards).model_dump_json()


def _settings_of_test(stage, wildcards):
    whole = training_study.settings_of_tests(TRIED, wildcards.get("noise", "none"))
    return select(whole, settings_type(stage_function(stage)), GRIPPER, wildcards.detector)


def weights_of_detector(wildcards):
    """The weights of a detector that is trained here; none for others."""
    network = NETWORKS.get(wildcards.detector)
    return [TRIED.detectors[network.name].weights] if network and is_trained(network) else []


def is_trained(network):
    """Whether a network of the training study is trained here."""
    return not SETTINGS.training_sets[network.training_set].weights


def detector_code(wildcards):
    """The code and weights of a detector that is not trained here: its trials depend on them."""
    if weights_of_detector(wildcards):
        return []
    try:
        return fingerprint(TRIED.detectors[wildcards.detector])
    except UserError as error:
        raise WorkflowError(f"The detector {wildcards.detector} cannot be used: {error}")


def of_set(file):
    """A file of the dataset that a training set is made from."""

    def chosen(wildcards):
        return f"results/{SETTINGS.training_sets[wildcards.training_set].dataset}/{file}"

    return chosen


def held_out_of_set(wildcards):
    """The evaluation set of this dataset, if it is held out for testing."""
    held = _settings_of_set(wildcards).render.hold_out
    return [of_set("eval49.parquet")(wildcards)] if held else []


def convex_parts_of_set(wildcards):
    """The convex parts of its objects, if its images are made with a simulation."""
    needed = _settings_of_set(wildcards).render.needs_convex_parts
    return [of_set(f"convex_parts/{GRIPPER}.parquet")(wildcards)] if needed else []


def shards_of_set(wildcards):
    """Numbers of the shards of the images of a training set."""
    return range(shard_count(_settings_of_set(wildcards).render.images))


def count_shards_of_set(wildcards):
    """How many there are."""
    return len(shards_of_set(wildcards))


def all_shards_of_set(pattern):
    """The files of all shards of a training set."""
    return lambda wildcards: expand(pattern, shard=shards_of_set(wildcards), **wildcards)


def images_of_set(wildcards):
    """The cards of all images that a network is trained on."""
    sources = training_study.image_sets(wildcards.training_set, SETTINGS.training_sets)
    return expand("results/training_study/images/{source}/card.md", source=sources)


def compared(wildcards):
    """The inputs of the training study: tests, trainings and images."""
    asked = SETTINGS.training_study
    for key, meaning in (("sets", "training set"), ("tests", "dataset to try networks on")):
        if not getattr(asked, key):
            raise WorkflowError(
                f"training_study.{key} names no {meaning}: lay config/training_study.yaml over the others"
            )
    study = "results/training_study"
    detectors = [*NETWORKS, *asked.references]
    trained = [network for network in NETWORKS.values() if is_trained(network)]
    names = dict.fromkeys(network.training_set for network in trained)
    images = [
        source
        for name in names
        for source in training_study.image_sets(name, SETTINGS.training_sets)
    ]
    return [
        *expand(
            f"{study}/trials/{{test}}/{{noise}}/{{detector}}.parquet",
            test=asked.tests,
            noise=asked.noise,
            detector=detectors,
        ),
        *expand(
            f"{study}/clutter/{{test}}/{{detector}}.parquet",
            test=asked.tests if asked.clutter else [],
            detector=detectors,
        ),
        *of_datasets(asked.tests, ["eval49.parquet", f"rescaled/{GRIPPER}/scales.parquet"]),
        *[
            f"{study}/networks/{each.folder}/{file}.parquet"
            for each in trained
            for file in ("history", "score")
        ],
        *expand(f"{study}/images/{{source}}/card.md", source=dict.fromkeys(images)),
    ]
