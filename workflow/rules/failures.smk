"""Failures: objects that can be grasped, but that a grasp detector does not grasp.

Inputs: results/D/archive.parquet; the weights of the detector, if a workflow makes them.
Outputs: results/D/failures/G/P.parquet, one row per failure; beside it P.examined.parquet, one row
per object that was looked at, P.attempts.parquet, and P.html, a page that explains them; made for
`targets.failures`.
Steps: `failures.shards` searches share the attempts; then their failures are merged into one
archive, and the detector is asked again why it failed; then attempts are filmed.
"""

from egad.bench.failures import DetectorFailures


rule search_failures:
    """Search for failures with a shard of the attempts."""
    input:
        archive="results/{dataset}/archive.parquet",
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        examined=ensure(
            "results/{dataset}/parts/failures_examined-{gripper}-{detector}-{shard}.parquet",
            non_empty=True,
        ),
        attempts=ensure(
            "results/{dataset}/parts/failures_attempts-{gripper}-{detector}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/search_failures/{gripper}-{detector}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/search_failures/{gripper}-{detector}-{shard}.tsv"
    # Start these jobs first: they take long.
    priority: 1
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=120),
    params:
        settings=settings_of(DetectorFailures),
        measures=MEASURES,
        code=code_of("search_failures"),
        contents=contents_of(gripper_files),
        sampler=sampler_code,
        detector=detector_code,
    message:
        "Searching for failures of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/search_failures.py"


rule join_failures:
    """Merge the failures of all shards, and ask the detector again why it failed."""
    input:
        examined=parts(
            "results/{dataset}/parts/failures_examined-{gripper}-{detector}-{shard}.parquet",
            FAILURE_SHARDS,
        ),
        attempts=parts(
            "results/{dataset}/parts/failures_attempts-{gripper}-{detector}-{shard}.parquet",
            FAILURE_SHARDS,
        ),
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        failures=ensure("results/{dataset}/failures/{gripper}/{detector}.parquet", non_empty=True),
        others=[
            "results/{dataset}/failures/{gripper}/{detector}.examined.parquet",
            "results/{dataset}/failures/{gripper}/{detector}.attempts.parquet",
        ],
    log:
        "logs/{dataset}/join_failures/{gripper}-{detector}.log",
    benchmark:
        "benchmarks/{dataset}/join_failures/{gripper}-{detector}.tsv"
    wildcard_constraints:
        dataset=ARCHIVED_DATASET,
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=2000, mb_per_thread=1000, minutes=60),
    params:
        settings=settings_of(DetectorFailures),
        code=code_of("join_failures"),
        contents=contents_of(gripper_files),
        sampler=sampler_code,
        detector=detector_code,
    message:
        "Joining the failures of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/join_failures.py"


rule explain_failures:
    """Write a page about the failures of a detector, with films of the worst."""
    input:
        failures="results/{dataset}/failures/{gripper}/{detector}.parquet",
        others=[
            "results/{dataset}/failures/{gripper}/{detector}.examined.parquet",
            "results/{dataset}/failures/{gripper}/{detector}.attempts.parquet",
        ],
    output:
        page="results/{dataset}/failures/{gripper}/{detector}.html",
    log:
        "logs/{dataset}/explain_failures/{gripper}-{detector}.log",
    benchmark:
        "benchmarks/{dataset}/explain_failures/{gripper}-{detector}.tsv"
    wildcard_constraints:
        dataset=ARCHIVED_DATASET,
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=2000, mb_per_thread=1000, minutes=30),
    params:
        code=code_of("explain_failures"),
    message:
        "Explaining the failures of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/explain_failures.py"
