"""Functions: training sets and the networks trained on them. No rules here."""


def settings_of_set(stage):
    """The same for a training set and, if the wildcards have a seed, a network."""

    def chosen(wildcards):
        network = training_study.Network(wildcards.training_set, int(wildcards.get("seed", 0)))
        whole = training_study.settings_for(SETTINGS, network)
        return _as_json(select(whole, settings_type(stage_function(stage)), GRIPPER))

    return chosen


def learnt(wildcards):
    """The weights of a detector that is trained here; none for others."""
    network = NETWORKS.get(wildcards.detector)
    return [TRIED.detectors[network.name].weights] if network and is_trained(network) else []


def is_trained(network):
    """Whether a network of the training study is trained here."""
    return SETTINGS.training_sets[network.training_set].dataset is not None


def detector_code(wildcards):
    """The code and weights of a detector that is not trained here: its trials depend on them."""
    if learnt(wildcards):
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
    held = SETTINGS.training_sets[wildcards.training_set].hold_out
    return [of_set("eval49.parquet")(wildcards)] if held else []


def parts_of_set(wildcards):
    """The convex parts of its objects, if its images are made with a simulation."""
    file = of_set(f"convex_parts/{GRIPPER}.parquet")
    return [file(wildcards)] if SETTINGS.render.needs_convex_parts else []


def files_of_the_gripper(wildcards):
    """The files that describe the gripper that training sets are for."""
    return files_of_gripper(GRIPPER)


def compared(wildcards):
    """The inputs of the training study: trials, evaluation, trained or images."""
    asked = SETTINGS.training_study
    for key, meaning in (("sets", "training set"), ("tests", "dataset to try networks on")):
        if not getattr(asked, key):
            raise WorkflowError(
                f"training_study.{key} names no {meaning}: lay config/training_study.yaml over the others"
            )
    networks = "results/training_study/networks"
    trained = [network for network in NETWORKS.values() if is_trained(network)]
    sets = sorted({network.training_set for network in trained})
    return [
        *expand(
            "results/{dataset}/trials/{gripper}/{detector}.parquet",
            dataset=asked.tests,
            gripper=GRIPPER,
            detector=[*NETWORKS, *asked.references],
        ),
        *of_datasets(asked.tests, ["eval49.parquet"]),
        *[
            f"{networks}/{each.folder}/{file}.parquet"
            for each in trained
            for file in ("history", "score")
        ],
        *expand("results/training_study/images/{training_set}/card.md", training_set=sets),
    ]
