#!/bin/bash
#SBATCH --job-name=orient-{{{name}}}
#SBATCH --cpus-per-task={{{cpus}}}
#SBATCH --mem={{{megabytes}}}M
#SBATCH --time={{{minutes}}}
#SBATCH --requeue
#SBATCH --output={{{logs}}}/{{{name}}}.log
#SBATCH --open-mode=append{{{more}}}
# {{{what}}}
set -u
{{{orient}}} block {{{block}}} {{{options}}}
code=$?
# 3: done, but some photos were not oriented; the report says why.
if [ $code -eq 3 ]; then exit 0; fi
if [ $code -eq 4 ] && [ -n "${SLURM_JOB_ID:-}" ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 5 ]; then
  sleep 60
  scontrol requeue "$SLURM_JOB_ID"
fi
exit $code
