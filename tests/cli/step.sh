#!/bin/bash
# A step above the stable one, and books of energy that do not close, are never passed over in silence.
source "$(dirname "$0")/../support/cli.sh"
cat >"$work/beam.yaml" <<'END'
title: A beam that swings
method: {time_step: 1e-3, duration: 0.5}
rods:
  - name: beam
    rest: {line: {to: [1, 0, 0], vertices: 21}}
    bending: 1
    twisting: 1
    linear_density: 1
    start: {clamp: edge}
forces: [{distributed: [0, 0, -1]}]
END
cat >"$work/apart.yaml" <<'END'
method: {time_step: 1e-3, duration: 1}
rods:
  - name: rope
    rest: {line: {to: [1, 0, 0], vertices: 11}}
    initial: {catenary: {to: [0.9, 0, 0], length: 1, vertices: 11}}
    bending: 1e-3
    twisting: 0
    vertex_mass: 1
    start: {position: fixed}
    end: {position: [x + t, fixed, fixed]}
END
# warned FILE WORD: is there a warning with this word in the report?
warned() { python3 -c 'import json, sys
with open(sys.argv[1]) as f: d = json.load(f)
sys.exit(0 if any(sys.argv[2] in w for w in d["warnings"]) else 1)' "$1" "$2"; }

run "$HEBRA" run "$work/beam.yaml" -o "$work/good"; wants 0
check "nothing is warned of at a good step" test -z "$(grep warning "$work/.err")"
check "no warning in the report" python3 -c 'import json, sys; sys.exit(json.load(open(sys.argv[1]))["warnings"] != [])' \
  "$work/good/report.json"

# The limit is l^2/2 sqrt(rho A/B) = 1.25e-3 here, a little less by the load.
run "$HEBRA" check "$work/beam.yaml" --set method.time_step=1.3e-3; wants 0 'warning' 'survives with a wrong answer'
run "$HEBRA" run "$work/beam.yaml" -o "$work/bad" --set method.time_step=2e-3
check "the run says at once that the step is too large" grep -q '^warning: the time step 0.002 is above 0.00125' "$work/.err"
check "and at the end that the books do not close" grep -q '^warning: the books of energy do not close' "$work/.err"
check "the report warns of the step" warned "$work/bad/report.json" 'above 0.00125'
check "the report warns of the books" warned "$work/bad/report.json" 'books of energy'
run "$HEBRA" run "$work/beam.yaml" -o "$work/bad" --set method.time_step=2e-3 --quiet
check "--quiet does not show the warnings" test -z "$(grep '^warning' "$work/.err")"
check "but the report has them" warned "$work/bad/report.json" 'above 0.00125'

# A chain has no bending waves: its weight gives the limit. Viscosity of bending lowers it.
stable() { "$HEBRA" check "$work/beam.yaml" --json "$@" | python3 -c 'import json, sys; print(json.load(sys.stdin)["stable_step"])'; }
near() { python3 -c 'import sys; a, b = map(float, sys.argv[1:]); sys.exit(abs(a / b - 1) > 0.01)' "$1" "$2"; }
check "a chain: l sqrt(rho A/T)" near "$(stable --set rods.beam.bending=0 --set rods.beam.twisting=0)" 0.05
check "viscosity: rho A l^4/(16 eta)" near "$(stable --set 'rods.beam.damping={bending: 1}')" 3.906e-7
check "mass damping: 1/c for Verlet" near "$(stable --set 'rods.beam.damping={mass: 1e6}')" 1e-6
check "mass damping: 2/c for Euler" near "$(stable --set 'rods.beam.damping={mass: 1e6}' --set method.integrator=symplectic-euler)" 2e-6
run "$HEBRA" check "$work/beam.yaml" --set rods.beam.bending=0 --set rods.beam.twisting=0 --set 'forces=[]'; wants 0 'no estimate'

# Steps that fail say why.
run "$HEBRA" run "$work/beam.yaml" -o "$work/worse" --set method.time_step=0.1 --set method.duration=100; wants 1 'is above'
run "$HEBRA" run "$work/apart.yaml" -o "$work/apart"; wants 1 'converge' 'apart, but the rod between them is only'
finish
