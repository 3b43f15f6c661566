#!/usr/bin/env bash
# An experiment as a Slurm job array: PARTS tasks, each of which runs its part of the cases into a folder of its own.
#   export EXPERIMENT=paper PARTS=20 OUT=/scratch/paper MUSCLEBENCH=/scratch/bin/musclebench
#   first=$(sbatch --parsable --array=1-$PARTS bench/experiments/cluster/slurm.sh)
#   sbatch --dependency=afterany:$first --wrap "tools/experiment $EXPERIMENT --merge $OUT/part-* --out $OUT/whole"
# From the project's folder. A task that was stopped goes on where it was: submit its number once more. Further options of
# tools/experiment: export OPTIONS="--data /scratch/lhdl". Times want nodes of one kind, and nobody else on them.
#SBATCH --job-name=musclebench
#SBATCH --exclusive
#SBATCH --requeue
set -eu
: "${EXPERIMENT:?names the experiment}" "${PARTS:?is the number of parts}" "${OUT:?is the folder of the results}"
: "${MUSCLEBENCH:?is the program that every node finds}"
# Slurm runs a copy of this file from elsewhere.
cd "${MUSCLEBENCH_ROOT:-$SLURM_SUBMIT_DIR}"
# shellcheck disable=SC2086
exec tools/experiment "$EXPERIMENT" --musclebench "$MUSCLEBENCH" --shard "$SLURM_ARRAY_TASK_ID/$PARTS" \
  --out "$OUT/part-$SLURM_ARRAY_TASK_ID" --jobs 1 ${OPTIONS:-}
