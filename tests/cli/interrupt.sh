#!/bin/bash
# Ctrl-C: the run finishes its frame, writes a checkpoint, says how to go on, ends with status 1; going on gives the bits of
# an undisturbed run. The same for a polite SIGTERM.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml
setting=(--set parameters.steps=3000)

run "$HEBRA" run $scene -o "$work/whole" --quiet "${setting[@]}"; wants 0
tables "$work/whole"
for signal in INT TERM; do
  dir=$work/$signal
  # A background job of a script ignores SIGINT; setsid and env start it as a terminal would.
  env --default-signal=INT "$HEBRA" run $scene -o "$dir" "${setting[@]}" --set parameters.steps=1000000 >"$work/.out" 2>"$work/.err" &
  pid=$!
  wait_for 20 test -s "$dir/checkpoint.hbc"
  check "the run has begun" test -s "$dir/checkpoint.hbc"
  pause 300
  kill -$signal $pid
  wait $pid
  status=$? out=$(<"$work/.out") err=$(<"$work/.err") command=(run with SIG$signal)
  wants 1 'stopped on request' "--restart $dir/checkpoint.hbc"
  run "$HEBRA" info "$dir/trajectory.h5"; wants 0
done

dir=$work/again
env --default-signal=INT "$HEBRA" run $scene -o "$dir" --quiet "${setting[@]}" >"$work/.out" 2>"$work/.err" &
pid=$!
wait_for 20 test -s "$dir/checkpoint.hbc"
kill -INT $pid
wait $pid
status=$? out=$(<"$work/.out") err=$(<"$work/.err") command=(run with SIGINT)
wants 1 'stopped on request'
check "no whole run yet" bash -c "! cmp -s '$dir/checkpoint.hbc' '$work/whole/checkpoint.hbc'"
run "$HEBRA" run --quiet --restart "$dir/checkpoint.hbc"; wants 0
check "the final state has the same bits" same "$dir/checkpoint.hbc" "$work/whole/checkpoint.hbc"
tables "$dir"
check "all frames have the same bits" diff -r "$dir/tables" "$work/whole/tables"
finish
