#!/usr/bin/env bash
# Submits all shares of a study to Slurm as one job array, and a job that puts them together.
#
#   slurm.sh SHARES DIR COMMAND…
#   slurm.sh 100 studies/many bodyschema study learners --trials 1000 --jobs 1
#
# Can be called again once its jobs have ended: only shares that are missing or were interrupted are submitted. What each share
# says is in DIR/logs/SHARE.txt, and what came out in DIR/logs/merge.txt. Options of sbatch, such as a partition, a time or
# how many shares run at once, are taken from its environment: SBATCH_PARTITION=long SBATCH_TIMELIMIT=2:00:00 slurm.sh …
set -euo pipefail
if [ $# -lt 4 ]; then
    echo "usage: $0 SHARES DIR bodyschema study … (without --shard and --out)" >&2
    exit 2
fi
shares=$1 dir=$2
shift 2
program=$1
mkdir -p "$dir/logs"
missing=1-$shares
if [ -d "$dir/shares" ]; then missing=$("$program" study merge "$dir" --missing); fi
wait=()
if [ -n "$missing" ]; then
    # Slurm starts it with the number of its share in the environment.
    array=$(sbatch --parsable --job-name bodyschema --array "$missing" --output "$dir/logs/%a.txt" --requeue <<SHARE
#!/usr/bin/env bash
exec $(printf '%q ' "$@") --quiet --shard "\$SLURM_ARRAY_TASK_ID/$shares" --out $(printf '%q' "$dir")
SHARE
    )
    echo "shares $missing: job $array"
    # It starts when all have ended, well or not, and names those that have to be made again.
    wait=(--dependency "afterany:${array%%;*}")
fi
merge=$(sbatch --parsable --job-name merge --output "$dir/logs/merge.txt" "${wait[@]}" <<MERGE
#!/usr/bin/env bash
exec $(printf '%q ' "$program" study merge "$dir")
MERGE
)
echo "merge: job $merge; what comes out will be in $dir/logs/merge.txt"
