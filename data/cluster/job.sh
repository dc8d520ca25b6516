#!/bin/bash
#SBATCH --job-name=orient-{{{name}}}
#SBATCH --cpus-per-task={{{cpus}}}
#SBATCH --mem={{{megabytes}}}M
#SBATCH --time={{{minutes}}}
#SBATCH --requeue
#SBATCH --kill-on-invalid-dep=yes
#SBATCH --output="{{{logs}}}/{{{log}}}.log"
#SBATCH --open-mode=append{{{more}}}
# {{{what}}}
set -u
{{{orient}}} {{{words}}}
code=$?
# 3: done, but some photos were not oriented (the report says why), or wait for those of other parts.
if [ $code -eq 3 ]; then exit 0; fi
# Killed, or 4: the machine refused (disk, memory, quota). The same again, later, perhaps elsewhere.
if [ $code -eq 4 ] || [ $code -gt 128 ]; then
  if [ -n "${SLURM_JOB_ID:-}" ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 5 ]; then
    [ $code -gt 128 ] || sleep 60
    scontrol requeue "$SLURM_JOB_ID"
  fi
fi
exit $code
