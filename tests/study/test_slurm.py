"""The tiny study as jobs of a real Slurm: munged, slurmctld and slurmd of this machine, on loopback.

Needs root and the Debian packages slurm-wlm and munge. Not every machine should start Slurm's services,
so ./run does not install these packages. Without them this test is skipped.
"""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT, TINY, run_study, write

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
CONFIG = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=8000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


@pytest.fixture(name="cluster")
def one_node_cluster(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """Starts the three services; skips where they do not come up."""
    monkeypatch.setenv("PATH", os.environ["PATH"] + ":/usr/sbin:/sbin")
    missing = [program for program in PROGRAMS if not shutil.which(program)]
    if missing:
        pytest.skip(f"Slurm is not installed ({missing[0]} is missing): apt-get install slurm-wlm munge")
    if os.geteuid() != 0:
        pytest.skip("Slurm's services are started as root only")
    folder = tmp_path / "slurm"
    (folder / "state").mkdir(parents=True)
    folder.chmod(0o755)
    (folder / "munge.key").write_bytes(os.urandom(1024))
    (folder / "munge.key").chmod(0o400)
    (folder / "slurm.conf").write_text(CONFIG.format(
        folder=folder, host=socket.gethostname().split(".")[0], ports=free_ports(2),
        cpus=len(os.sched_getaffinity(0))))
    monkeypatch.setenv("SLURM_CONF", str(folder / "slurm.conf"))
    services = [
        ["munged", "--foreground", "--force", f"--key-file={folder}/munge.key",
         f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
         f"--seed-file={folder}/munged.seed"],
        ["slurmctld", "-D", "-c", "-f", f"{folder}/slurm.conf"],
        ["slurmd", "-D", "-f", f"{folder}/slurm.conf"]]
    running = []
    try:
        for service in services:
            with open(folder / f"{service[0]}.log", "w", encoding="utf-8") as log:
                running.append(subprocess.Popen(service, stdout=log, stderr=log))
            time.sleep(1)
        for _ in range(60):
            shown = subprocess.run(["sinfo", "--noheader", "--format=%T"], capture_output=True, text=True,
                                   check=False)
            if shown.stdout.strip() == "idle":
                break
            time.sleep(0.5)
        else:
            said = [(folder / f"{service[0]}.log").read_text().strip().splitlines()[-1:]
                    for service in services]
            pytest.skip(f"Slurm does not start here: {shown.stdout}{shown.stderr} {said}")
        yield folder
    finally:
        for service in reversed(running):
            service.terminate()
            service.wait(timeout=30)


def test_the_same_study_on_slurm(cluster: Path, tmp_path: Path) -> None:
    file = write(tmp_path, TINY)
    output = tmp_path / "results"
    # Snakemake 7 does not quote the path of a profile's script; ROOT may have a space.
    profile = shutil.copytree(ROOT / "apps/study/slurm", tmp_path / "profile")
    done = run_study(file, output, "--", "--profile", str(profile))
    assert done.returncode == 0, done.stderr
    # The scene, two jobs for the initial mesh, five for each variant; tables and report stay here.
    assert len(list((output / "slurm").glob("*.log"))) == 3 + 2 * 5
    log = (cluster / "slurmctld.log").read_text()
    assert log.count("WEXITSTATUS 0") >= 11, log
    here = tmp_path / "here"
    assert run_study(file, here).returncode == 0
    for mesh in sorted(output.glob("runs/*/*/refine/refined.ply")):
        assert mesh.read_bytes() == (here / mesh.relative_to(output)).read_bytes()
