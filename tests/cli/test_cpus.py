import os

import pytest

from egad.cli.cpus import available_cpus

MOUNT = "32 31 0:29 {top} {place} rw,relatime shared:9 - {kind} {kind} rw{options}\n"


@pytest.fixture(autouse=True)
def many(monkeypatch):
    monkeypatch.delenv("PYTHON_CPU_COUNT", raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))


def machine(root, groups, mounts, files):
    """Files below /proc and /sys."""
    texts = {"proc/self/cgroup": groups, "proc/self/mountinfo": mounts, **files}
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return available_cpus(root)


def v2(place="/sys/fs/cgroup", top="/"):
    return MOUNT.format(kind="cgroup2", place=place, top=top, options="")


def v1(top="/"):
    other = MOUNT.format(kind="cgroup", place="/sys/fs/cgroup/memory", top=top, options=",memory")
    place = "/sys/fs/cgroup/cpu,cpuacct"
    return other + MOUNT.format(kind="cgroup", place=place, top=top, options=",cpu,cpuacct")


GROUP = "sys/fs/cgroup/cpu,cpuacct"


@pytest.mark.parametrize(
    ("groups", "mounts", "files", "count"),
    [
        ("", "", {}, 8),
        ("0::/\n", v2(), {"sys/fs/cgroup/cpu.max": "200000 100000\n"}, 2),
        ("0::/\n", v2(), {"sys/fs/cgroup/cpu.max": "max 100000\n"}, 8),
        ("0::/\n", v2(), {"sys/fs/cgroup/cpu.max": "250000 100000\n"}, 3),
        ("0::/\n", v2(), {"sys/fs/cgroup/cpu.max": "10000 100000\n"}, 1),
        ("0::/\n", v2(), {"sys/fs/cgroup/cpu.max": "6400000 100000\n"}, 8),
        # a group inside one that grants less
        (
            "0::/a/b\n",
            v2(),
            {
                "sys/fs/cgroup/a/b/cpu.max": "400000 100000\n",
                "sys/fs/cgroup/a/cpu.max": "300000 100000\n",
            },
            3,
        ),
        # both versions, of which the first has the processors
        (
            "4:memory:/\n3:cpu,cpuacct:/job\n0::/\n",
            v1() + v2("/sys/fs/cgroup/unified"),
            {f"{GROUP}/job/cpu.cfs_quota_us": "50000\n", f"{GROUP}/job/cpu.cfs_period_us": "50000"},
            1,
        ),
        (
            "3:cpu,cpuacct:/\n",
            v1(),
            {f"{GROUP}/cpu.cfs_quota_us": "-1\n", f"{GROUP}/cpu.cfs_period_us": "100000\n"},
            8,
        ),
        # a container that sees its own group as the outermost, by the name that the host gives it
        (
            "3:cpu,cpuacct:/docker/1f2e\n",
            v1("/docker/1f2e"),
            {f"{GROUP}/cpu.cfs_quota_us": "150000\n", f"{GROUP}/cpu.cfs_period_us": "100000\n"},
            2,
        ),
    ],
)
def test_the_processors_that_a_container_grants(tmp_path, groups, mounts, files, count):
    assert machine(tmp_path, groups, mounts, files) == count


def test_a_disk_whose_name_is_not_utf8_does_not_matter(tmp_path):
    machine(tmp_path, "0::/\n", "", {"sys/fs/cgroup/cpu.max": "200000 100000\n"})
    usb = MOUNT.format(kind="vfat", place="/media/M\xfcsli", top="/", options="")
    (tmp_path / "proc/self/mountinfo").write_bytes((usb + v2()).encode("latin-1"))
    assert available_cpus(tmp_path) == 2


@pytest.mark.parametrize(("text", "count"), [("3", 3), ("0", 1), ("default", 8), ("64", 64)])
def test_the_variable_of_python_decides(tmp_path, monkeypatch, text, count):
    monkeypatch.setenv("PYTHON_CPU_COUNT", text)
    assert available_cpus(tmp_path) == count
