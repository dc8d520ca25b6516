#!/bin/bash
# The same jobs on this machine, {{{at_once}}} at a time. As in the cluster each begins when those
# before it have ended, however they ended; the last one decides whether all is done.
set -uo pipefail
unset SLURM_JOB_ID  # the scripts would ask for that job to be repeated
cd "$(dirname "$0")" || exit 1
mkdir -p logs
code=0
array() {  # script, number of tasks
  local log=logs/$(basename "$1" .sh)
  seq 1 "$2" | xargs -P {{{at_once}}} -I{} bash -c \
    "SLURM_ARRAY_TASK_ID={} bash $1 >>${log}_{}.log 2>&1"
  code=$?
}
submit() {  # its script, and after what end of the one before it
  if [ "${2:-}" = afterok ] && [ $code -ne 0 ]; then return; fi
  bash "$1" >>"logs/$(basename "$1" .sh).log" 2>&1
  code=$?
}
{{{jobs}}}
[ $code -eq 0 ] || echo "$0: a job has failed; the logs lie in $PWD/logs" >&2
exit $code
