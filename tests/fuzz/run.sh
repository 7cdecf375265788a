#!/bin/bash
# Runs a fuzz target over its kept corpus, then looks for new inputs:  run.sh TARGET CORPUS SECONDS
# New inputs stay in the scratch directory; one that breaks something is printed, to be put into the corpus.
set -euo pipefail
target=$1 corpus=$2 seconds=$3
scratch=${HEBRA_SCRATCH:?}
[ -n "$(ls -A "$corpus" 2>/dev/null)" ] || { echo "the corpus $corpus is empty"; exit 1; }
rm -rf "$scratch" && mkdir -p "$scratch/new"
options=(-rss_limit_mb=2048 -timeout=20 -max_len=16384 -artifact_prefix="$scratch/broken-")
dictionary=${corpus%/corpus/*}/$(basename "$corpus").dict
[ ! -f "$dictionary" ] || options+=("-dict=$dictionary")
cd "$scratch"
"$target" "${options[@]}" -runs=0 "$corpus"
"$target" "${options[@]}" -max_total_time="$seconds" -print_final_stats=1 "$scratch/new" "$corpus" 2>&1 | tail -n 30
