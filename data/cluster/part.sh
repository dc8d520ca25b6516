#!/bin/bash
#SBATCH --job-name=orient-{{{stage}}}
#SBATCH --array=1-{{{parts}}}
#SBATCH --cpus-per-task=1
#SBATCH --mem={{{megabytes}}}M
#SBATCH --time={{{minutes}}}
#SBATCH --requeue
#SBATCH --output="{{{logs}}}/{{{stage}}}_%a.log"
#SBATCH --open-mode=append{{{more}}}
# Task K does the photos K, K + {{{parts}}}, K + 2 x {{{parts}}} ... of the block. What is done is kept,
# whoever did it: a task may be repeated at any time, and what a lost one has left the next job does.
set -u
{{{orient}}} block {{{block}}} --stage {{{stage}}} --part "$SLURM_ARRAY_TASK_ID/{{{parts}}}" --jobs 1
code=$?
# 3: some photos wait for those of other parts.
if [ $code -eq 3 ]; then exit 0; fi
# Killed, or 4: the machine refused (disk, memory, quota). The same again, later, perhaps elsewhere.
if [ $code -eq 4 ] || [ $code -gt 128 ]; then
  if [ -n "${SLURM_JOB_ID:-}" ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 5 ]; then
    [ $code -gt 128 ] || sleep 60
    scontrol requeue "$SLURM_JOB_ID"
  fi
fi
exit $code
