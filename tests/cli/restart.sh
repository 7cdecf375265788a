#!/bin/bash
# --restart: a run cut short by --set goes no further; checkpoints that fit nothing are refused with a sentence.
source "$(dirname "$0")/../support/cli.sh"
source tests/support/runs.sh
scene=tests/support/small.yaml
run "$HEBRA" run $scene -o "$work/whole" --quiet; wants 0
cp "$work/whole/checkpoint.hbc" "$work/kept.hbc"

# From the end there is nothing to do, and nothing changes.
run "$HEBRA" run --restart "$work/whole/checkpoint.hbc" --quiet; wants 0
check "a finished run stays as it is" same "$work/whole/checkpoint.hbc" "$work/kept.hbc"

run "$HEBRA" run --restart "$work/nothing.hbc"; wants 2 nothing.hbc
printf 'no checkpoint' >"$work/text.hbc"
run "$HEBRA" run --restart "$work/text.hbc"; wants 2 text.hbc
size=$(stat -c %s "$work/kept.hbc")
for part in 1 8 40 $((size / 2)) $((size - 1)); do
  head -c "$part" "$work/kept.hbc" >"$work/cut.hbc"
  run "$HEBRA" run --restart "$work/cut.hbc" -o "$work/cut"; wants 2 cut.hbc
done
# One bit anywhere in it.
RANDOM=7
for i in {1..12}; do
  cp "$work/kept.hbc" "$work/bit.hbc"
  at=$(((RANDOM * 32768 + RANDOM) % size))
  byte=$(od -An -tu1 -j $at -N 1 "$work/kept.hbc")
  printf "\\x$(printf %02x $((byte ^ 16)))" | dd of="$work/bit.hbc" bs=1 seek=$at conv=notrunc status=none
  run "$HEBRA" run --restart "$work/bit.hbc" -o "$work/bit"; wants 2 bit.hbc
done
check "nothing is written from a bad checkpoint" test ! -e "$work/cut" -a ! -e "$work/bit"

run "$HEBRA" run $scene --restart "$work/kept.hbc"; wants 2
run "$HEBRA" run --restart "$work/kept.hbc" --set method.time_step=1e-4; wants 2 --set method.duration
run "$HEBRA" run --restart "$work/kept.hbc" --set method.duration=1 --set output.every=1; wants 2 output.every
run "$HEBRA" run --restart "$work/whole"; wants 2 directory checkpoint.hbc
# The trajectory that belongs to the checkpoint is gone, or there is not even a directory.
mkdir "$work/alone"
for place in alone nowhere; do
  run "$HEBRA" run --restart "$work/kept.hbc" -o "$work/$place"; wants 2 trajectory.h5 'must hold'
done
check "nothing is written by a restart without its trajectory" test -z "$(ls "$work/alone")" -a ! -e "$work/nowhere"

# A finished run is made longer: the same bits as a run that was that long from the start, also where the last frame of
# the short one lies between the regular ones.
run "$HEBRA" run $scene -o "$work/long" --quiet --set method.duration=0.4; wants 0
run "$HEBRA" run $scene -o "$work/odd" --quiet --set method.duration=0.123; wants 0
for name in whole odd; do
  run "$HEBRA" run --restart "$work/$name/checkpoint.hbc" --set method.duration=0.4 --quiet; wants 0
  check "$name, made longer, ends in the same bits" same "$work/$name/checkpoint.hbc" "$work/long/checkpoint.hbc"
  tables "$work/$name"
  [ -d "$work/long/tables" ] || tables "$work/long"
  check "$name, made longer, has the same frames" diff -rq "$work/$name/tables" "$work/long/tables"
done
run "$HEBRA" run --restart "$work/long/checkpoint.hbc" --set method.duration=0.1; wants 2 already method.duration
finish
