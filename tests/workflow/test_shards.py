import pandas as pd
from join import run as join_files

from egad.tables import parquet
from egad.tables.objects import REJECTED, rejection
from egad_workflow.shards import by_shard, in_shard, join, rows_in_shard

IDS = [f"object-{number}" for number in range(200)]


def test_every_object_is_in_exactly_one_shard():
    for shards in (1, 3, 8):
        homes = [[in_shard(each, shard, shards) for shard in range(shards)] for each in IDS]
        assert {sum(home) for home in homes} == {1}


def test_shards_list_the_objects_that_are_in_them():
    listed = by_shard(IDS, 3)
    for shard, found in enumerate(listed):
        assert found == [each for each in IDS if in_shard(each, shard, 3)]


def test_shards_are_of_similar_size():
    sizes = [sum(in_shard(each, shard, 4) for each in IDS) for shard in range(4)]
    assert min(sizes) > 30


def test_the_number_of_shards_leaves_no_trace(tmp_path):
    rows = [rejection(each, "postprocess", "empty") for each in IDS]

    def joined(shards):
        paths = []
        for shard in range(shards):
            part = pd.DataFrame([row for row in rows if in_shard(row["id"], shard, shards)])
            paths.append(tmp_path / f"{shards}-{shard}.parquet")
            parquet.write(part, REJECTED, paths[-1])
        return join(paths, REJECTED, ["id"])

    assert joined(3).equals(joined(7))
    assert len(joined(3)) == 200


def test_nothing_but_empty_shards_gives_an_empty_table(tmp_path):
    parquet.write(parquet.empty(REJECTED), REJECTED, tmp_path / "a")
    assert len(join([tmp_path / "a"], REJECTED, ["id"])) == 0


def test_rows_of_all_shards_are_the_table():
    frame = pd.DataFrame({"id": IDS})
    rows = pd.concat([rows_in_shard(frame, shard, 3) for shard in range(3)])
    assert sorted(rows["id"]) == sorted(IDS)


def test_a_joined_file_keeps_the_meanings_of_its_columns(tmp_path):
    rows = pd.DataFrame([rejection(each, "postprocess", "empty") for each in ("b", "a")])
    parquet.write(rows, REJECTED, tmp_path / "part")
    join_files([tmp_path / "part"], ["id"], tmp_path / "whole")
    assert parquet.schema_of(tmp_path / "whole").equals(REJECTED, check_metadata=True)
    assert list(parquet.read(tmp_path / "whole", REJECTED)["id"]) == ["a", "b"]
