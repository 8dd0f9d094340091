import pandas as pd

from egad import tables
from egad.stages.shards import in_shard, join, rejection, rows_in_shard

IDS = [f"object-{number}" for number in range(200)]


def test_every_object_is_in_exactly_one_shard():
    for shards in (1, 3, 8):
        homes = [[in_shard(each, shard, shards) for shard in range(shards)] for each in IDS]
        assert {sum(home) for home in homes} == {1}


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
            tables.write(part, tables.REJECTED, paths[-1])
        return join(paths, tables.REJECTED, ["id"])

    assert joined(3).equals(joined(7))
    assert len(joined(3)) == 200


def test_nothing_but_empty_shards_gives_an_empty_table(tmp_path):
    tables.write(tables.empty(tables.REJECTED), tables.REJECTED, tmp_path / "a")
    assert len(join([tmp_path / "a"], tables.REJECTED, ["id"])) == 0


def test_rows_of_an_empty_table_keep_its_columns():
    rows = rows_in_shard(tables.empty(tables.OBJECTS), 0, 2)
    assert list(rows.columns) == tables.OBJECTS.names


def test_rows_of_all_shards_are_the_table():
    frame = pd.DataFrame({"id": IDS})
    rows = pd.concat([rows_in_shard(frame, shard, 3) for shard in range(3)])
    assert sorted(rows["id"]) == sorted(IDS)
