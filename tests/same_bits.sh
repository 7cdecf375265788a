#!/bin/bash
# Runs scenes with every program given and compares the final states byte by byte: gcc and clang, with and without
# optimisation, must agree to the last bit.
#   tests/same_bits.sh SOURCE PROGRAM PROGRAM ...
set -euo pipefail
cd "$1"
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
for scene in scenes/thesis-1-twisted scenes/thesis-1-as-printed scenes/thesis-2-catenary scenes/thesis-3-tree tests/support/small; do
  first=
  for program in "$@"; do
    dir=$work/$(basename "$scene").$(dirname "$program" | tr / -)
    "$program" run "$scene.yaml" -o "$dir" --quiet --set method.duration=0.4
    if [ -z "$first" ]; then first=$dir
    elif cmp "$first/checkpoint.hbc" "$dir/checkpoint.hbc"; then echo "$scene: $program has the bits of $1"
    else echo "$scene: $program differs from $1"; status=1; fi
  done
done
exit $status
