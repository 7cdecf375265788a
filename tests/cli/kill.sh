#!/bin/bash
# A run killed by SIGKILL at 20 moments: its file opens, and the restart ends with the same bits as a run nobody disturbed.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml

# Long enough to be hit: half a second and more beyond the time that a run needs to get going, whatever the build.
begin=$(now)
run "$HEBRA" run $scene -o "$work/whole" --quiet --set parameters.steps=5; wants 0
start_up=$(($(now) - begin)) steps=100 took=0
while [ $took -lt 500 ] && [ $steps -lt 1000000 ]; do
  steps=$((steps * (took > 100 ? 700 / took + 1 : 3)))
  begin=$(now)
  run "$HEBRA" run $scene -o "$work/whole" --quiet --set parameters.steps=$steps
  took=$(($(now) - begin - start_up))
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
  # Every fourth somewhere in the first moments, the others evenly over the run.
  if [ $((moment % 4)) = 0 ]; then pause $((RANDOM % (start_up + 20)))
  else
    wait_for 20 test -e "$dir/checkpoint.hbc"
    pause $((RANDOM % (took * 4 / 5)))
  fi
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
