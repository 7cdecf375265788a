#!/bin/bash
# A run killed by SIGKILL at 20 moments: its file opens, and the restart ends with the same bits as a run nobody disturbed.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml

# Long enough to be hit: some tenths of a second beyond the time that a run needs to get going, whatever the build.
begin=$(now)
run "$HEBRA" run $scene -o "$work/whole" --quiet --set parameters.steps=5; wants 0
start_up=$(($(now) - begin)) steps=100 took=0
while [ $took -lt 300 ] && [ $steps -lt 1000000 ]; do
  steps=$((steps * (took > 100 ? 400 / took + 1 : 3)))
  begin=$(now)
  run "$HEBRA" run $scene -o "$work/whole" --quiet --set parameters.steps=$steps
  took=$(($(now) - begin - start_up))
done
wants 0
setting=(--set "parameters.steps=$steps")
tables "$work/whole"
echo "$steps steps take $took ms"

# starts_and_is_killed DIR FIRST PAUSE: true if the kill hit the run at work; FIRST: kill without waiting for a checkpoint.
starts_and_is_killed() {
  local pid
  rm -rf "$1"
  "$HEBRA" run $scene -o "$1" --quiet "${setting[@]}" >"$work/.out" 2>&1 &
  pid=$!
  [ "$2" = 1 ] || wait_for 20 test -e "$1/checkpoint.hbc"
  pause "$3"
  kill -KILL $pid 2>/dev/null
  wait $pid 2>/dev/null
  [ $? = 137 ]
}

RANDOM=20 opened=0 restarted=0 late=0
for moment in {1..20}; do
  dir=$work/killed-$moment
  # Every fourth somewhere in the first moments, the others evenly over the run. A run that was over before the kill does
  # not count: the machine has become faster than it was when the run was timed.
  while :; do
    first=$((moment % 4 == 0))
    starts_and_is_killed "$dir" $first $((RANDOM % (first ? start_up + 20 : took * 4 / 5 + 1))) && break
    late=$((late + 1)) took=$((took * 3 / 4))
    if [ $late = 30 ]; then
      fail "runs end before they are killed"
      finish
    fi
  done

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
echo "$opened trajectories opened, $restarted restarted from a checkpoint, $late runs were too fast"
check "most trajectories were there to be opened" test $opened -ge 12
check "most runs went on from a checkpoint" test $restarted -ge 12
finish
