#!/bin/bash
# A run killed by SIGKILL at 20 moments: its file opens, and the restart ends with the same bits as a run nobody disturbed.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml

# Long enough to be hit: about a second, whatever the build.
steps=100
while :; do
  start=$(now)
  run "$HEBRA" run $scene -o "$work/whole" --quiet --set "parameters.steps=$steps"
  took=$(($(now) - start))
  [ "$took" -gt 600 ] || [ "$steps" -gt 1000000 ] && break
  steps=$((steps * (took > 100 ? 900 / took + 1 : 4)))
done
wants 0
setting=(--set "parameters.steps=$steps")
tables "$work/whole"
echo "$steps steps take $took ms"

RANDOM=20 killed=0 opened=0 restarted=0
for moment in {1..20}; do
  dir=$work/killed-$moment
  "$HEBRA" run $scene -o "$dir" --quiet "${setting[@]}" >"$work/.out" 2>&1 &
  pid=$!
  # Evenly over the run and beyond its beginning, with some at the very start.
  pause $((RANDOM % (took * 4 / 5) * (moment % 5 > 0) + RANDOM % 30))
  kill -KILL $pid 2>/dev/null && killed=$((killed + 1))
  wait $pid 2>/dev/null

  if [ -e "$dir/trajectory.h5" ]; then
    run "$HEBRA" info "$dir/trajectory.h5"; wants 0 && opened=$((opened + 1))
  fi
  if [ -e "$dir/checkpoint.hbc" ]; then
    run "$HEBRA" run --quiet --restart "$dir/checkpoint.hbc"
    wants 0 && restarted=$((restarted + 1))
  else
    run "$HEBRA" run $scene -o "$dir" --quiet "${setting[@]}"; wants 0
  fi
  check "moment $moment: the final state has the same bits" same "$dir/checkpoint.hbc" "$work/whole/checkpoint.hbc"
  tables "$dir"
  check "moment $moment: all frames have the same bits" diff -r "$dir/tables" "$work/whole/tables"
  rm -rf "$dir"
done
echo "$killed killed while running, $opened trajectories opened, $restarted restarted from a checkpoint"
check "most kills hit a run at work" test $killed -ge 12
check "most trajectories were there to be opened" test $opened -ge 10
check "most runs went on from a checkpoint" test $restarted -ge 10
finish
