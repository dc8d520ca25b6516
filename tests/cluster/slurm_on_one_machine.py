"""A private Slurm on this machine: controller and two node daemons, in a temporary folder.

    with SlurmOnOneMachine(folder) as slurm: slurm.run("sbatch", ...)

Needs root, and Debian's slurm-wlm and munge. It has its own ports and sockets, so that an installed
Slurm is not affected. As a script, it sets one up under FOLDER and runs until interrupted:

    slurm_on_one_machine.py FOLDER
"""

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue")
NODES = ("n1", "n2")
CONFIGURATION = """\
ClusterName=orient
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
ReturnToService=2
SlurmdTimeout=10
KillWait=2
MpiDefault=none
SchedulerParameters=sched_interval=2,bf_interval=2
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
{nodes}
PartitionName=main Nodes={names} Default=YES MaxTime=INFINITE State=UP
"""


def why_not_here():
    if os.geteuid() != 0:
        return "a Slurm of one's own needs root"
    missing = [program for program in PROGRAMS if not shutil.which(program)]
    return f"not installed: {', '.join(missing)} (slurm-wlm, munge)" if missing else None


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class SlurmOnOneMachine:
    def __init__(self, folder, cpus=1, memory_mb=4000):
        self.folder = pathlib.Path(folder)
        self.nodes = {name: free_port() for name in NODES}
        host = socket.gethostname().partition(".")[0]
        lines = "\n".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} "
                          f"CPUs={cpus} RealMemory={memory_mb}" for name, port in self.nodes.items())
        self.configuration = CONFIGURATION.format(host=host, port=free_port(), folder=self.folder,
                                                  nodes=lines, names=",".join(NODES))
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def __enter__(self):
        (self.folder / "state").mkdir(parents=True)
        self.folder.chmod(0o755)
        (self.folder / "slurm.conf").write_text(self.configuration, encoding="utf-8")
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.run("munged", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                 f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/munge.log",
                 f"--seed-file={self.folder}/munge.seed")
        self.run("slurmctld", "-c")
        for node in NODES:
            self.start_node(node)
        self.wait_until(lambda: self.run("sinfo", "-h", "-o", "%T").split() == ["idle"], 60)
        return self

    def __exit__(self, *_):
        subprocess.run(["scancel", "--user", "root"], env=self.environment, check=False)
        for node in NODES:
            self.kill_node(node)
        for daemon in ("slurmctld", "munged"):
            self._kill(self._pid(daemon))

    def run(self, *words):
        done = subprocess.run(list(map(str, words)), env=self.environment, capture_output=True,
                              text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, words))}: {done.stdout}{done.stderr}")
        return done.stdout

    def start_node(self, node):
        self.run("slurmd", "-N", node)

    def kill_node(self, node):
        """Simulates the loss of a machine: kills its daemon and everything that runs on it."""
        daemon = self._pid(node)
        for step in self.steps(node):
            self._kill_tree(step)
        self._kill(daemon)

    def steps(self, node):
        """Ids of the node's slurmstepd processes, recognised by their files in its spool folder."""
        found = []
        for process in pathlib.Path("/proc").iterdir():
            if not process.name.isdigit():
                continue
            try:
                if (process / "comm").read_text() == "slurmstepd\n" and any(
                        f"spool.{node}" in os.readlink(file)
                        for file in (process / "fd").iterdir()):
                    found.append(int(process.name))
            except OSError:
                pass
        return found

    def waiting_or_running(self):
        return self.run("squeue", "-h", "-r").splitlines()

    def wait_until(self, condition, seconds):
        until = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > until:
                raise RuntimeError(f"Slurm has not come so far after {seconds} s:\n"
                                   + self.run("squeue") + self.run("sinfo"))
            time.sleep(0.5)

    def _pid(self, daemon):
        try:
            return int((self.folder / f"{daemon}.pid").read_text())
        except (OSError, ValueError):
            return None

    @staticmethod
    def _kill(pid):
        if pid is None:
            return
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def _kill_tree(self, pid):
        children = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True,
                                  check=False).stdout.split()
        self._kill(pid)
        for child in children:
            self._kill_tree(int(child))


def main(folder):
    reason = why_not_here()
    if reason:
        sys.exit(reason)
    with SlurmOnOneMachine(pathlib.Path(folder).resolve()) as slurm:
        print(f"export SLURM_CONF={slurm.folder}/slurm.conf", flush=True)
        signal.sigwait({signal.SIGINT, signal.SIGTERM})


if __name__ == "__main__":
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    main(*sys.argv[1:])
