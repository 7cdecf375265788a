#!/usr/bin/env python3
"""docs/theory/errata.md says what the tests show:  tests/check_errata.py [--page FILE] PROGRAM ...

- every row of the page has a test of its name in tests/physics/test_errata_*.c, and every such test a row,
- the figure of the printed form is the one that the test prints (to 2 %),
- our figure is within the bound that the page gives.
PROGRAM ...: the test programs, which print "NAME printed NUMBER ours NUMBER" with HEBRA_TEST_VERBOSE=1.
"""
import os
import pathlib
import re
import subprocess
import sys

ROW = re.compile(r'^\| ([EP]\d+) \|.*\| ([0-9.e+-]+) \| < ([0-9.e+-]+) \|$', re.M)
NAMED = re.compile(r'^\| ([EP]\d+) \|', re.M)
TEST = re.compile(r'cmocka_unit_test\(test_([EP]\d+)\)')
FIGURE = re.compile(r'^([EP]\d+) printed (\S+) ours (\S+)$', re.M)


def duplicates(names):
    """Names that stand more than once."""
    return sorted({n for n in names if names.count(n) > 1})


def main():
    """Compares page, sources and output; says every difference."""
    root = pathlib.Path(__file__).resolve().parent.parent
    args = sys.argv[1:]
    page = root / 'docs/theory/errata.md'
    if args and args[0] == '--page':
        page, args = pathlib.Path(args[1]), args[2:]
    text = page.read_text()
    rows = {name: (float(printed), float(ours)) for name, printed, ours in ROW.findall(text)}
    named = NAMED.findall(text)
    tests = [n for f in sorted((root / 'tests/physics').glob('test_errata_*.c')) for n in TEST.findall(f.read_text())]
    faults = [f'row {n} stands twice' for n in duplicates(named)]
    faults += [f'test_{n} stands twice' for n in duplicates(tests)]
    faults += [f'row {n} has no figures at its end: "| NUMBER | < BOUND |"' for n in named if n not in rows]
    faults += [f'row {n} has no test: test_{n}' for n in named if n not in tests]
    faults += [f'test_{n} has no row' for n in tests if n not in named]
    figures = {}
    for program in args:
        run = subprocess.run([program], env=dict(os.environ, HEBRA_TEST_VERBOSE='1'), capture_output=True, text=True)
        if run.returncode:
            faults.append(f'{program} fails')
        figures.update({n: (float(p), float(o)) for n, p, o in FIGURE.findall(run.stdout)})
    for name, (printed, bound) in rows.items():
        if not args or name not in tests:
            continue
        if name not in figures:
            faults.append(f'test_{name} prints no figures')
            continue
        shown, ours = figures[name]
        if abs(shown - printed) > 0.02 * abs(shown):
            faults.append(f'{name}: the page says {printed:g} of the printed form, the test {shown:g}')
        if not ours <= bound:
            faults.append(f'{name}: the page says that ours is below {bound:g}, the test {ours:g}')
    for fault in faults:
        print(f'{page.name}: {fault}')
    if not faults:
        print(f'{len(rows)} rows, each with its test' + (' and its figures' if args else ''))
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
