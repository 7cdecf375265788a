#!/bin/bash
# Every scene of tests/broken gets its exact sentence (NAME.expected) from run and from check, with status 2, and leaves
# nothing behind. NAME.set holds --set arguments, one per line.
source "$(dirname "$0")/../support/cli.sh"
cd tests/broken || exit 1
count=0
for scene in *.yaml; do
  name=${scene%.yaml}
  settings=()
  if [ -f "$name.set" ]; then
    while IFS= read -r line; do settings+=(--set "$line"); done <"$name.set"
  fi
  expected=$(<"$name.expected")
  for verb in run check; do
    target=()
    [ $verb = check ] || target=(-o "$work/out")
    run "$HEBRA" $verb "$scene" "${target[@]}" "${settings[@]}"
    wants 2 || continue
    [ "$err" = "hebra $verb: $expected" ] || fail "$name: the sentence expected is: $expected"
    [ -z "$out" ] || fail "$name: nothing expected on standard output"
  done
  [ ! -e "$work/out" ] || { fail "$name: something is left in the output directory"; rm -rf "$work/out"; }
  count=$((count + 1))
done
check "at least 80 broken scenes are kept" test $count -ge 80
echo "$count broken scenes"
finish
