"""A Slurm cluster of one node, this machine, for as long as a test needs it (root; no systemd)."""

import os
import shutil
import socket
import subprocess
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "munged", "setpriv")
# Jobs look for it there: the executor takes SLURM_CONF away from them.
CONF = Path("/etc/slurm/slurm.conf")
MARK = "# made by the tests of egad\n"
# Memory is watched by looking at the processes, since there may be no cgroups; finished jobs stay
# known to squeue, since there is no database for sacct.
TEXT = """\
ClusterName=onenode
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={worker}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_interval=1,sched_min_interval=100000
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
ReturnToService=2
MinJobAge=3600
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def why_not():
    """Why there can be no cluster on this machine; empty if there can."""
    missing = [name for name in PROGRAMS if not shutil.which(name)]
    if missing:
        return f"{', '.join(missing)} needed (Debian: apt-get install slurm-wlm munge)"
    if os.geteuid() != 0:
        return "only root can start Slurm"
    if CONF.exists() and not CONF.read_text().startswith(MARK):
        return f"{CONF} belongs to another cluster"
    return ""


@contextmanager
def cluster(folder):
    """Start munge and Slurm, wait until the node is idle, and stop them at the end."""
    with ExitStack() as stack:
        if not munge_answers():
            stack.enter_context(munge())
        write_conf(folder)
        stack.callback(CONF.unlink)
        for program in ("slurmctld", "slurmd"):
            stack.enter_context(daemon([program, "-D", "-c"]))
        if not within(30, node_is_idle):
            logs = [path.read_text()[-2000:] for path in folder.glob("*.log")]
            raise RuntimeError("\n".join(["Slurm did not start", *logs]))
        yield


def write_conf(folder):
    """The configuration of a node with all cores and nearly all memory of this machine."""
    for name in ("state", "spool"):
        (folder / name).mkdir()
    pages = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    controller, worker = free_ports()
    text = TEXT.format(
        host=socket.gethostname().partition(".")[0],
        folder=folder,
        cpus=os.cpu_count(),
        memory=(pages >> 20) - 512,
        controller=controller,
        worker=worker,
    )
    CONF.parent.mkdir(exist_ok=True)
    CONF.write_text(MARK + text)


def free_ports():
    """Two ports that nobody listens at."""
    with socket.socket() as one, socket.socket() as other:
        one.bind(("127.0.0.1", 0))
        other.bind(("127.0.0.1", 0))
        return one.getsockname()[1], other.getsockname()[1]


def munge():
    """The daemon by which Slurm's parts trust each other, under its own user."""
    run = Path("/run/munge")
    run.mkdir(exist_ok=True)
    shutil.chown(run, "munge", "munge")
    user = ["--reuid=munge", "--regid=munge", "--init-groups"]
    return daemon(["setpriv", *user, "munged", "--foreground"], ready=munge_answers)


def munge_answers():
    """Whether a daemon of munge runs already."""
    return answers(["munge", "--no-input"])


def node_is_idle():
    """Whether the node takes jobs."""
    return answers(["sinfo", "--noheader", "--format", "%T"], "idle")


def answers(command, said=""):
    """Whether a command succeeds and says something."""
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    return result.returncode == 0 and said in result.stdout


@contextmanager
def daemon(command, ready=lambda: True):
    """A process that is ended at the end; `ready` says when it can be used."""
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            if not within(10, ready):
                raise RuntimeError(f"{command[0]} did not start")
            yield
        finally:
            process.terminate()


def within(seconds, true):
    """Ask until the answer is yes; whether it came in time."""
    end = time.monotonic() + seconds
    while not (found := true()) and time.monotonic() < end:
        time.sleep(0.2)
    return found
