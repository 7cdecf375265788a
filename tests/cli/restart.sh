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

# Two checkpoints agree but for the number of the run (bytes 16 to 23) and the check sum of everything (the last 8).
without_run() { head -c 16 "$1"; tail -c +25 "$1" | head -c -8; }
same_state() { cmp -s <(without_run "$1") <(without_run "$2"); }

# A finished run is made longer: the same bits as a run that was that long from the start, also where the last frame of
# the short one lies between the regular ones.
run "$HEBRA" run $scene -o "$work/long" --quiet --set method.duration=0.4; wants 0
run "$HEBRA" run $scene -o "$work/odd" --quiet --set method.duration=0.123; wants 0
for name in whole odd; do
  run "$HEBRA" run --restart "$work/$name/checkpoint.hbc" --set method.duration=0.4 --quiet; wants 0
  check "$name, made longer, ends in the same bits" same_state "$work/$name/checkpoint.hbc" "$work/long/checkpoint.hbc"
  tables "$work/$name"
  [ -d "$work/long/tables" ] || tables "$work/long"
  check "$name, made longer, has the same frames" diff -rq "$work/$name/tables" "$work/long/tables"
done
run "$HEBRA" run --restart "$work/long/checkpoint.hbc" --set method.duration=0.1; wants 2 already method.duration

# Another scene in the directory of an older run: killed at once, it leaves its own checkpoint and no older report.
sed 's/^title:.*/title: Another scene/' $scene >"$work/another.yaml"
run "$HEBRA" run $scene -o "$work/mix" --quiet; wants 0
cp "$work/mix/checkpoint.hbc" "$work/stale.hbc"
"$HEBRA" run "$work/another.yaml" -o "$work/mix" --quiet --set output.checkpoint=1000 --set output.every=1000 \
  --set method.duration=1e3 &
other=$!
wait_for 20 test ! -e "$work/mix/report.json"
wait_for 20 test -e "$work/mix/checkpoint.hbc"
kill -9 $other
wait $other 2>/dev/null
check "the older report is gone" test ! -e "$work/mix/report.json"
check "the older checkpoint is replaced" bash -c "! cmp -s '$work/mix/checkpoint.hbc' '$work/stale.hbc'"
# Even the older checkpoint put back does no harm to the trajectory.
cp "$work/mix/trajectory.h5" "$work/mix.h5"
cp "$work/mix/checkpoint.hbc" "$work/mix.hbc"
cp "$work/stale.hbc" "$work/mix/checkpoint.hbc"
run "$HEBRA" run --restart "$work/mix/checkpoint.hbc" --quiet; wants 2 'belongs to another run' 'Another scene'
check "the trajectory is left as it was" same "$work/mix/trajectory.h5" "$work/mix.h5"
cp "$work/mix.hbc" "$work/mix/checkpoint.hbc"
run "$HEBRA" run --restart "$work/mix/checkpoint.hbc" --quiet --set method.duration=0.05; wants 0

# A disk that takes no more bytes: one sentence, status 1, and what is there opens.
limited() { (trap '' XFSZ; ulimit -f "$1"; shift; "$@"); }
for blocks in 4 8 24 48 100; do
  run limited $blocks "$HEBRA" run $scene -o "$work/full$blocks" --quiet; wants 1 'File too large'
  check "$blocks blocks: one sentence" test "$(wc -l <"$work/.err")" = 1
  check "$blocks blocks: nothing half written stays" test -z "$(ls "$work/full$blocks")"
done
finish
