#!/bin/bash
# hebra bench: groups, options, tables, JSON; nothing is left behind. bench/record keeps it, bench/report shows it.
source "$(dirname "$0")/../support/cli.sh"
export TMPDIR=$work/tmp
mkdir -p "$TMPDIR"
# judge CODE: Python that looks at the JSON of the last run as b; false fails.
judge() { python3 -c "import json, sys; b = json.load(open(sys.argv[1])); assert ($1), b" "$work/.out"; }

run "$HEBRA" bench one --quick --sizes 25,1000
wants 0 'GFlop/s with fused multiply-adds' 'bandwidth: L1' 'one: one rod' 'isotropic symplectic-euler' 'general   verlet' 'project'
check "a row for each rod, integrator and size" test "$(grep -c '^\(isotropic\|general\) .*%$' <<<"$out")" = 8
check "stages of the middle size" test "$(grep -c ' L1$' <<<"$out")" -ge 16
check "no other group" test "$(grep -c '^\(many\|start\|output\):' <<<"$out")" = 0

run "$HEBRA" bench --json --quick --sizes 60
wants 0
check "all groups" judge '[s["group"] for s in b["steps"] if s["group"] != "threads"] ==
  4 * ["one"] + 12 * ["many"] + 8 * ["precision"] and len(b["start"]) == 5 and
  len(b["output"]) == 3'
check "the machine" judge 'b["machine"]["gflops_double"] > 0.05 and b["machine"]["processors"] > 0 and
  0 < b["machine"]["core_share"] < 1.05 and
  all(b["machine"]["gbytes_per_second"][level] > 0.01 for level in ("L1", "L2", "L3", "memory"))'
check "one rod of 60 vertices" judge 'all(s["vertices"] == 60 and s["rods"] == 1 for s in b["steps"][:4])'
check "shapes of many rods" judge '[(s["rods"], s["vertices"], s["vertices_in_all"]) for s in b["steps"]][4:7] ==
  [(1000, 50, 50000), (100, 100, 10000), (1000, None, 49976)]'
check "threads from 1 to all" judge '{s["threads"] for s in b["steps"]} >= {1, b["machine"]["processors"]} and
  all(s["threads"] == 1 for s in b["steps"] if s["group"] != "threads")'
check "both precisions; single needs less memory" judge '[s["precision"] for s in b["steps"]][-8:] == 4 * ["double", "single"] and
  all(s["memory_per_vertex"] < d["memory_per_vertex"] for d, s in zip(b["steps"][-8::2], b["steps"][-7::2]))'
check "every case has its figures" judge 'all(s["ns_per_vertex_step"] > 0 and s["projections_per_step"] > 0 and
  s["memory_per_vertex"] > 100 and (s["of_peak"] is None if s["precision"] == "single" else
  s["of_peak"] > 0 and s["bytes"] > 100 and s["of_bandwidth"] > 0) for s in b["steps"])'
check "the twist of general rods is iterated" judge '[s["twist_iterations_per_step"] > 0 for s in b["steps"]] ==
  [s["rod"] == "general" for s in b["steps"]]'
check "stages make up the whole" judge 'all(abs(sum(t["share"] for t in s["stages"].values()) - 1) < 1e-9 and
  min(t["share"] for t in s["stages"].values()) >= -1e-9 and
  set(s["stages"]) == {"twist", "elastic", "loads", "move", "project"} for s in b["steps"])'
# Rates are what was counted over what was timed.
check "rates fit" judge 'all(abs(s["gflops"] / b["machine"]["gflops_double"] / s["of_peak"] / s["threads"] - 1) < 1e-9 and
  abs(s["bytes"] / s["ns_per_vertex_step"] / s["gbytes_per_second"] - 1) < 1e-9 for s in b["steps"]
  if s["precision"] == "double")'
check "small scenes start at once" judge '0 < b["start"][0]["ms"] < 500 and "thesis-3-tree" in b["start"][4]["what"]'
check "output is written" judge 'all(o["bytes_per_frame"] > 100 * o["vertices"] for o in b["output"])'

run "$HEBRA" bench start --quick --scenes "$work/none"; wants 0 'text to first step' "$work/none/thesis-1-twisted.yaml" '--scenes'
run "$HEBRA" bench oen; wants 2 '"oen" is not a group' 'one, many'
run "$HEBRA" bench --sizes 4; wants 2 '--sizes "4"' '5 to 10000000'
run "$HEBRA" bench --sizes 25,; wants 2 '--sizes "25,"'
run "$HEBRA" bench --sizes; wants 2 '--sizes needs a value'
run env TMPDIR="$work/nowhere" "$HEBRA" bench output --quick; wants 1 "$work/nowhere/hebra-bench" TMPDIR
check "nothing is left behind" test -z "$(ls -A "$TMPDIR")"

# Two records, the second twice as fast.
results=$work/results.jsonl
run bench/record --quick --no-counts --hebra "$HEBRA" --results "$results" --note "a test" start; wants 0 '0 cases into'
python3 - "$results" <<'EDIT'
import json, sys
first = json.loads(open(sys.argv[1]).read())
assert first['note'] == 'a test' and first['instructions'] == {} and len(first['start_ms']) == 5, first
case = {'ns': 60.0, 'of_peak': 0.1, 'of_bandwidth': None, 'level': 'L1', 'memory': 350.0}
with open(sys.argv[1], 'w') as file:
    for scale in (1, 0.5):
        print(json.dumps({**first, 'steps': {'isotropic-verlet-1x1000': {**case, 'ns': scale * case['ns']}}}), file=file)
EDIT
check "a record has what it should" test "$(wc -l <"$results")" = 2
run bench/report --results "$results"; wants 0 'nanoseconds' 'isotropic-verlet-1x1000' '-50.0 %'
run bench/report --results "$results" --what start_ms; wants 0 'milliseconds' 'thesis-3-tree'
run bench/report --results "$results" --plot "$work/plot.png"; wants 0 '2 records'
check "a chart" begins_with "$work/plot.png" '\211PNG'
run bench/report --results "$results" --plot "$work/plot.pdf"; wants 1 '.png or .svg'
run bench/report --results "$results" --processor nobody; wants 1 '"nobody"'
echo '{' >>"$results"; run bench/report --results "$results"; wants 1 'results.jsonl:3:'
finish
