#!/usr/bin/env bash
# Makes all shares of a session or a study with HyperQueue, whose server and workers run, and puts them together.
#
#   hyperqueue.sh SHARES DIR COMMAND…
#   hyperqueue.sh 16 sessions/big bodyschema babble mjcf/max/max.xml --touches 100000 --jobs 1
#
# Can be called again at any time: only shares that are missing or were interrupted are made. What each share says is in
# DIR/logs/SHARE.txt.
set -euo pipefail
if [ $# -lt 4 ]; then
    echo "usage: $0 SHARES DIR bodyschema babble|study … (without --shard and --out)" >&2
    exit 2
fi
shares=$1 dir=$2
shift 2
program=$1
mkdir -p "$dir/logs"
missing=1-$shares
if [ -d "$dir/shares" ]; then missing=$("$program" merge "$dir" --missing); fi
if [ -n "$missing" ]; then
    hq submit --wait --name bodyschema --array "$missing" --crash-limit 2 \
        --stdout "$dir/logs/%{TASK_ID}.txt" --stderr "$dir/logs/%{TASK_ID}.txt" -- \
        bash -c 'exec "$@" --quiet --shard "$HQ_TASK_ID/$0"' "$shares" "$@" --out "$dir" ||
        echo "some shares failed: see $dir/logs" >&2
fi
exec "$program" merge "$dir"
