#!/bin/bash
# Writing beside the run: with one processor, where the run writes by itself, and with several, the files have the same
# bytes; a file that cannot be written ends the run with its sentence, the files as they were, and status 1.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml
setting=(--set parameters.steps=2000 --set output.every=3)
one=()
if command -v taskset >/dev/null; then
  first=$(taskset -cp $$ | sed 's/.*: *\([0-9]*\).*/\1/')
  one=(taskset -c "$first")
fi

for checkpoint in 0 1000; do
  run "$HEBRA" run $scene -o "$work/all" --quiet "${setting[@]}" --set output.checkpoint=$checkpoint; wants 0
  run "${one[@]}" "$HEBRA" run $scene -o "$work/one" --quiet "${setting[@]}" --set output.checkpoint=$checkpoint; wants 0
  check "the same trajectory" same "$work/all/trajectory.h5" "$work/one/trajectory.h5"
  check "the same checkpoint" same "$work/all/checkpoint.hbc" "$work/one/checkpoint.hbc"
done
# Progress comes in order and to the end, by whichever thread.
run "$HEBRA" run $scene -o "$work/all" "${setting[@]}"; wants 0 ' 10%' '100%' '668 frames in'
percents=$(grep -o '^ *[0-9]*%' "$work/.err" | tr -d ' %')
check "progress goes up" test "$percents" = "$(sort -n <<<"$percents")"

# The directory goes away under the run.
for how in "${one[*]}" ""; do
  rm -rf "$work/lost"
  $how "$HEBRA" run $scene -o "$work/lost" --quiet --set parameters.steps=100000000 --set output.checkpoint=0 \
    --set output.every=1000 >"$work/.out" 2>"$work/.err" &
  pid=$!
  wait_for 20 test -e "$work/lost/checkpoint.hbc"
  mv "$work/lost" "$work/away"
  wait $pid
  status=$? out=$(<"$work/.out") err=$(<"$work/.err") command=("$how" run in a directory that goes away)
  wants 1 'lost/checkpoint.hbc: cannot be written: No such file or directory'
  check "one sentence" test "$(wc -l <"$work/.err")" = 1
  run "$HEBRA" info "$work/away/trajectory.h5"; wants 0
  rm -rf "$work/away"
done
finish
