#!/usr/bin/env bash
# Makes all shares of a study with GNU parallel, on this machine or on several, and puts them together.
#
#   parallel.sh SHARES DIR COMMAND…
#   parallel.sh 100 studies/many bodyschema study learners --trials 1000 --jobs 1
#
# Can be called again at any time: only shares that are missing or were interrupted are made. What each share says is in
# DIR/logs; which failed, and how often, is in DIR/logs/parallel.tsv. Several machines that have DIR and the model in the
# same place: PARALLEL='--sshlogin 8/host1,8/host2 --workdir .' parallel.sh …
set -euo pipefail
if [ $# -lt 4 ]; then
    echo "usage: $0 SHARES DIR bodyschema study … (without --shard and --out)" >&2
    exit 2
fi
shares=$1 dir=$2
shift 2
program=$1
mkdir -p "$dir/logs"
missing=$(seq -s, "$shares")
if [ -d "$dir/shares" ]; then missing=$("$program" study merge "$dir" --missing); fi
if [ -n "$missing" ]; then
    # A share that fails is tried once more, and does not keep the others from being made.
    tr , '\n' <<<"$missing" | parallel --quote --retries 2 --joblog "$dir/logs/parallel.tsv" \
        bash -c 'log=$1; shift; exec "$@" >"$log" 2>&1' share "$dir/logs/{}.txt" \
        "$@" --quiet --shard "{}/$shares" --out "$dir" || echo "$?" shares failed: see "$dir/logs" >&2
fi
exec "$program" study merge "$dir"
