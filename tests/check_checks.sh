#!/bin/bash
# The checks of the house find what they are there for: each rule is broken once in a small tree.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=$PWD/tools
tree=${HEBRA_SCRATCH:?}/tree
failed=0

# A clean tree with one file in it.
fresh() {
  rm -rf "$tree"
  mkdir -p "$tree"/{include/hebra,src/base,src/math,src/rod,src/force,src/sim,cli}
  printf '#include "hebra/base.h"\n/* Adds one. */\nint hb_one(int x) {\n  return x + 1;\n}\n' >"$tree/src/base/one.c"
}
# expect pass|fail WORDS COMMAND...: the command passes, or fails and says WORDS.
expect() {
  local wanted=$1 words=$2 status=0 said
  shift 2
  said=$("$@" 2>&1) || status=$?
  if [ "$wanted" = pass ] && [ $status = 0 ]; then return; fi
  if [ "$wanted" = fail ] && [ $status != 0 ] && [[ $said == *"$words"* ]]; then return; fi
  echo "expected $wanted ($words) of: $*"
  echo "status $status: $said"
  failed=$((failed + 1))
}

fresh; expect pass '' "$tools/check_floors" "$tree"
fresh; echo '#include "rod/rod.h"' >"$tree/src/base/up.c"
expect fail '(floor 1) includes "rod/rod.h" (floor 5)' "$tools/check_floors" "$tree"
fresh; echo '#include "force/wind.h"' >"$tree/src/rod/side.c"
expect fail '(floor 5) includes "force/wind.h"' "$tools/check_floors" "$tree"
fresh; echo '#include "hebra/sim.h"' >"$tree/src/rod/public.c"
expect fail 'includes "hebra/sim.h" (floor 8)' "$tools/check_floors" "$tree"
fresh; echo '#include <hdf5.h>' >"$tree/src/sim/outside.c"
expect fail 'includes <hdf5.h>, which sim may not use' "$tools/check_floors" "$tree"
fresh; mkdir "$tree/src/attic"; echo '#include "hebra/base.h"' >"$tree/src/attic/a.c"
expect fail 'without a floor' "$tools/check_floors" "$tree"
fresh; printf '#include "hebra/sim.h"\n#include "rod/rod.h"\n#include "sim/own.h"\n' >"$tree/src/sim/down.c"
expect pass '' "$tools/check_floors" "$tree"

fresh; expect pass '' "$tools/check_sizes" "$tree"
# lines N: a captioned function of N lines
lines() {
  printf '/* Long. */\nvoid hb_long(void) {\n'
  for ((i = 0; i < $1 - 2; i++)); do printf '  if (0) { const char *s = "}"; (void)s; }\n'; done
  printf '}\n'
}
fresh; lines 100 >"$tree/src/base/long.c"; expect pass '' "$tools/check_sizes" "$tree"
fresh; lines 101 >"$tree/src/base/long.c"; expect fail 'hb_long has 101 lines' "$tools/check_sizes" "$tree"
fresh; for ((i = 0; i < 801; i++)); do echo '#define HB_A 1'; done >"$tree/src/base/file.c"
expect fail 'the file has 801 lines' "$tools/check_sizes" "$tree"
fresh; printf 'int hb_two(int x) {\n  return x + 2;\n}\n' >"$tree/src/base/bare.c"
expect fail 'hb_two has no caption' "$tools/check_sizes" "$tree"
fresh; printf '/* %0110d */\n' 0 >"$tree/src/base/wide.c"
expect fail '116 columns' "$tools/check_sizes" "$tree"

# symbols CODE: a library of one object file with this code
symbols() {
  printf '#include <stdio.h>\n#include <stdlib.h>\n%s\n' "$1" >"$tree/probe.c"
  cc -std=c17 -fPIC -O1 -c "$tree/probe.c" -o "$tree/probe.o"
  rm -f "$tree/libprobe.a"
  ar rc "$tree/libprobe.a" "$tree/probe.o"
}
check=("$tools/check_symbols" "$tree/libprobe.a")
fresh
symbols 'const char *const hb_names[] = {"a", "b"}; static const int t[] = {1}; int hb_f(int i) { return t[i]; }'
expect pass '' "${check[@]}"
symbols 'int hb_f(void) { static int n; return n++; }'; expect fail 'is writable data' "${check[@]}"
symbols 'int hb_n = 3;'; expect fail 'hb_n is writable data' "${check[@]}"
symbols '_Thread_local int hb_n; '; expect fail 'hb_n is writable data' "${check[@]}"
symbols 'void *hb_f(int n) { return malloc(n); }'; expect fail 'calls malloc' "${check[@]}"
symbols 'void hb_f(int n) { printf("%d", n); }'; expect fail 'uses printf' "${check[@]}"
symbols 'void hb_f(void) { exit(1); }'; expect fail 'uses exit' "${check[@]}"
symbols 'int hb_f(void) { return rand(); }'; expect fail 'uses rand' "${check[@]}"
symbols 'int other(void) { return 1; }'; expect fail 'other is visible outside' "${check[@]}"
expect fail 'cannot read' "$tools/check_symbols" "$tree/nothing.a"

errata=docs/theory/errata.md
expect pass '' tests/check_errata.py
sed '/^| E7 /d' $errata >"$tree/page.md"
expect fail 'test_E7 has no row' tests/check_errata.py --page "$tree/page.md"
sed 's/^| E7 /| E77 /' $errata >"$tree/page.md"
expect fail 'row E77 has no test' tests/check_errata.py --page "$tree/page.md"
sed '/^| P3 /s/ 22 / /' $errata >"$tree/page.md"
expect fail 'row P3 has no figures' tests/check_errata.py --page "$tree/page.md"
# figures CODE: a test program that prints these
figures() {
  printf '#!/bin/sh\n%s "$@"\n' "sed -nE 's/^[|] ([EP][0-9]+) .*[|] ([0-9.e+-]+) [|] < .*/\\1 printed \\2 ours 0/p' $errata | sed '$1'" \
    >"$tree/figures"
  chmod +x "$tree/figures"
}
figures ''; expect pass '' tests/check_errata.py "$tree/figures"
figures 's/^E7 printed .* ours/E7 printed 9 ours/'
expect fail 'E7: the page says 0.108 of the printed form, the test 9' tests/check_errata.py "$tree/figures"
figures '/^E7/s/ours 0/ours 1/'
expect fail 'E7: the page says that ours is below 1e-09, the test 1' tests/check_errata.py "$tree/figures"

[ $failed = 0 ] && echo "every rule is enforced"
