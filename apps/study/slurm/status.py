#!/usr/bin/python3
"""`status.py JOB`: prints running, success or failed, as Snakemake's --cluster-status asks for."""

import re
import subprocess
import sys

RUNNING = {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING",
           "STAGE_OUT", "SIGNALING"}


def state_of(job: str) -> str:
    """The state of a job by Slurm's controller, or, when that has forgotten it, by its accounting."""
    shown = subprocess.run(["scontrol", "--oneliner", "show", "job", job], capture_output=True,
                           text=True, check=False)
    if state := re.search(r"\bJobState=(\w+)", shown.stdout):
        return state[1]
    listed = subprocess.run(["sacct", "--jobs", job, "--allocations", "--noheader", "--parsable2",
                             "--format=State"], capture_output=True, text=True, check=False)
    return (listed.stdout.split() or ["UNKNOWN"])[0]


STATE = state_of(sys.argv[1].split(";")[0])  # --parsable prints "job;cluster" on federations
print("success" if STATE == "COMPLETED" else "running" if STATE in RUNNING else "failed")
