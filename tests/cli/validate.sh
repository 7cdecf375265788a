#!/bin/bash
# hebra validate: the fast cases hold, reports, selection, cases of one's own, cases that fail, broken check files.
source "$(dirname "$0")/../support/cli.sh"
# figure FILE EXPRESSION: does a Python expression on the report d hold?
figure() { python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2"; }

run "$HEBRA" validate --fast --no-plots -o "$work/fast"; wants 0 'V02 elastica-tip' 'cases hold' 'not yet' 'order 2.0'
fast=$work/fast/report.json
check "all of them hold" figure "$fast" 'd["failed"] == 0 and d["wrong"] == 0 and d["cases"] >= 45 and d["numbers"] >= 350'
check "what is not yet is listed" figure "$fast" \
  'd["not_yet"] == sum(1 for r in d["results"] if r["not_yet"]) >= 5 and any(r["id"] == "V27" for r in d["results"])'
check "numbers with errors, tolerances, orders, meshes" figure "$fast" \
  'all(abs(n["error"]) <= n["tolerance"] for r in d["results"] for n in r["numbers"])'
check "orders over three meshes and more" figure "$fast" \
  'sum(1 for r in d["results"] for n in r["numbers"] if n["order"] and len(n["meshes"]) >= 3) > 50'
check "a report for people" grep -q '^## V12\|^## V02 elastica-tip' "$work/fast/report.md"
check "without plots" test -z "$(ls "$work/fast" | grep png)"

# threads change nothing; --json
run "$HEBRA" validate V01 V33 --no-plots -o "$work/one" --threads 1 --json --quiet; wants 0
check "the report on standard output" test "$out" = "$(<"$work/one/report.json")"
run "$HEBRA" validate V01 V33 --no-plots -o "$work/two" --threads 2; wants 0 '2 of 2 cases hold'
check "the same numbers with two threads" test "$(grep -v '"seconds"\|"wall_seconds"\|"threads"' "$work/one/report.json")" \
  = "$(grep -v '"seconds"\|"wall_seconds"\|"threads"' "$work/two/report.json")"

# plots, where gnuplot is
if command -v gnuplot >/dev/null; then
  run "$HEBRA" validate elastica-tip wave -o "$work/plots"; wants 0
  check "a picture for each" begins_with "$work/plots/elastica-tip.png" '\x89PNG'
  check "also for one without meshes" begins_with "$work/plots/wave.png" '\x89PNG'
  check "the report shows it" grep -q '(wave.png)' "$work/plots/report.md"
fi
run env PATH=/nowhere "$HEBRA" validate wave -o "$work/bare"; wants 0 'note: no plots' 'gnuplot-nox'
check "the report does without" test -z "$(grep png "$work/bare/report.md")"

# selection
run "$HEBRA" validate --list; wants 0 'localised-buckling' 'capstan' 'contact'
check "a list computes nothing" test ! -e out/validate
run "$HEBRA" validate V99; wants 2 'there is no case "V99"' '--list'
run "$HEBRA" validate --cases "$work/none"; wants 2 "$work/none"
mkdir "$work/empty"
run "$HEBRA" validate --cases "$work/empty"; wants 2 'holds no file NAME.check.yaml'
for number in 0 -1 x 1025; do run "$HEBRA" validate --threads "$number"; wants 2 "--threads \"$number\""; done

# a case of one's own: by the check file, by the scene beside it, with its own scene below another directory
cp tests/checks/scene.yaml "$work/mine.yaml"
cat >"$work/mine.check.yaml" <<'YAML'
title: My cantilever
solve:
vary: {P: [0.25, 1]}
meshes: {n: [21, 41, 81]}
size: 1/(n - 1.5)
read: {tip: "position.z[-1]"}
expect: [{name: deflection, find: -tip, is: [0.08274591535442, 0.3017207737998], within: 1e-3, order: 2, limit: 1e-5}]
YAML
for file in mine.check.yaml mine.yaml; do
  run "$HEBRA" validate "$work/$file" --no-plots -o "$work/own"; wants 0 'mine: My cantilever' '1 of 1 cases hold' 'P = 0.25'
done
# what fails says so, and the rest is computed; --quiet shows only that
sed -i 's/0.3017207737998/0.3117207737998/' "$work/mine.check.yaml"
run "$HEBRA" validate "$work/mine.yaml" V33 --no-plots -o "$work/own" --quiet
wants 1 '1 of 2 cases hold (2 of 3 numbers)' 'FAIL deflection (P = 1)' 'the error is larger than the tolerance'
check "quiet: not what holds" test -z "$(grep 'P = 0.25\|V33' <<<"$out")"
check "the reports tell as well" figure "$work/own/report.json" \
  'd["failed"] == 1 and [n["holds"] for r in d["results"] for n in r["numbers"]].count(False) == 1'
sed -i 's/0.3117207737998/0.3017207737998/; s/order: 2/order: 1/' "$work/mine.check.yaml"
run "$HEBRA" validate "$work/mine.yaml" --no-plots -o "$work/own"; wants 1 'the order of convergence is another one'
sed -i 's/order: 1, limit: 1e-5/order: 2, limit: 1e-12/' "$work/mine.check.yaml"
run "$HEBRA" validate "$work/mine.yaml" --no-plots -o "$work/own"; wants 1 'on ever finer meshes'
# a scene that cannot be computed fails its case alone, with its sentence
sed -i 's/limit: 1e-12/limit: 1e-5/; s/0.25, 1\]/0.25, 1], "rods[0].bending": [1, -1]/' "$work/mine.check.yaml"
run "$HEBRA" validate "$work/mine.yaml" --no-plots -o "$work/own"; wants 1 'ok   deflection (P = 0.25)' 'FAIL deflection (P = 1)' '"-1" is not allowed'

# broken check files get their exact sentence, and nothing is written
cd tests/checks || exit 1
count=0
for file in broken-*.check.yaml; do
  run "$HEBRA" validate "$file" --no-plots -o "$work/broken"; wants 2 || continue
  [ "$err" = "hebra validate: $(<"${file%.check.yaml}.expected")" ] || fail "$file: another sentence is expected"
  [ ! -e "$work/broken" ] || fail "$file: something is written"
  count=$((count + 1))
done
check "at least 30 broken check files are kept" test $count -ge 30
finish
