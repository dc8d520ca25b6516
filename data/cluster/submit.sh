#!/bin/bash
# Submits the block's jobs to Slurm. Each waits for those before it to end, however they end: what a
# lost task has left undone is done by the next job. Where that cannot be, it says so and fails.
set -euo pipefail
cd "$(dirname "$0")"
mkdir -p logs
after=""
submitted=()
# Half a chain is of no use.
trap '[ ${#submitted[@]} -eq 0 ] || scancel "${submitted[@]}"' ERR
submit() {  # its script, and after what end of those before it
  local id
  id=$(sbatch --parsable ${after:+--dependency=${2:-afterany}:$after} "$1")
  after=${id%%;*}
  submitted+=("$after")
  echo "$after  $1"
}
set -E
{{{jobs}}}
