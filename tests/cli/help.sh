#!/bin/bash
# Help texts, version, unknown verbs, wrong arguments, output that cannot be written.
source "$(dirname "$0")/../support/cli.sh"
verbs=(run solve modes check info export render plot bench validate)

run "$HEBRA"; wants 2 'usage: hebra VERB'
for word in --help -h help; do
  run "$HEBRA" $word; wants 0 'usage: hebra VERB' 'Exit status' "${verbs[@]}"
  check "help goes to standard output" test -n "$out" -a -z "$err"
done
run "$HEBRA" --version; wants 0 'hebra 0.1.0'
for verb in "${verbs[@]}"; do
  run "$HEBRA" "$verb" --help; wants 0 "hebra $verb" 'xample'
  check "help of $verb goes to standard output" test -n "$out" -a -z "$err"
  check "help of $verb fits 120 columns" test "$(wc -L <<<"$out")" -le 120
  whole=$out
  run "$HEBRA" help "$verb"; wants 0; check "hebra help $verb is the same" test "$out" = "$whole"
  run "$HEBRA" "$verb" -h; wants 0; check "hebra $verb -h is the same" test "$out" = "$whole"
  run "$HEBRA" "$verb" --no-such-option; wants 2 "hebra $verb" 'no-such-option' "hebra $verb --help"
  check "a wrong option of $verb gives no standard output" test -z "$out"
done
for verb in run solve modes check info export render plot; do
  run "$HEBRA" "$verb"; wants 2 "hebra $verb" "hebra $verb --help"
  arguments=()
  [ $verb != export ] || arguments=(--format csv)
  run "$HEBRA" "$verb" "$work/nothing-here" "${arguments[@]}"; wants 2 'nothing-here'
done

for number in 0 -1 1.5 two 1025 ''; do
  run "$HEBRA" run tests/support/small.yaml -o "$work/out" --threads "$number"
  wants 2 "--threads \"$number\" is not a whole number from 1 to 1024"
done
run "$HEBRA" run tests/support/small.yaml -o "$work/out" --threads 2 --quiet --set method.duration=0.01; wants 0

# typed wanted
while read -r typed wanted; do
  run "$HEBRA" "$typed"; wants 2 "there is no verb '$typed'" "the nearest one is '$wanted'"
done <<'WORDS'
rnu run
Run run
chek check
informations info
exprot export
rendre render
plto plot
benchmark bench
WORDS
run "$HEBRA" "$(printf 'x%.0s' {1..500})"; wants 2 'there is no verb'
run "$HEBRA" ''; wants 2 'there is no verb'

# A full disk turns success into failure.
run bash -c '"$0" --help >/dev/full' "$HEBRA"; wants 1 'cannot write to standard output'
run bash -c '"$0" run --help >/dev/full' "$HEBRA"; wants 1 'cannot write to standard output'
finish
