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
run "$HEBRA" run --restart "$work/kept.hbc" --set method.duration=1; wants 2 --set
# The trajectory that belongs to the checkpoint is gone.
mkdir "$work/alone"
run "$HEBRA" run --restart "$work/kept.hbc" -o "$work/alone"
check "a restart without its trajectory says so" test "$status" != 0 -a -n "$err"
finish
