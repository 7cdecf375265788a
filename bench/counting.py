"""Counts of what a step executes, by valgrind: what bench/gate, bench/count and bench/record share."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
INTEGRATORS = ('symplectic-euler', 'verlet')
KINDS = ('isotropic', 'general')
# group: rods, vertices of each, steps that are not counted, steps that are
SHAPES = {'one': (1, 200, 40, 200), 'many': (24, 50, 20, 60)}
# Every case by name.
CASES = {f'{group}-{kind}-{integrator}': (kind, integrator, *shape)
         for group, shape in SHAPES.items() for kind in KINDS for integrator in INTEGRATORS}


class Trouble(Exception):
    """A sentence for the user."""


def needs_valgrind():
    """Ends with the status of a skipped test where there is no valgrind."""
    if not shutil.which('valgrind'):
        print('valgrind is not here (tools/install-packages test installs it): nothing can be counted')
        sys.exit(77)


def program(given=None):
    """The program that steps one case, from the command line, the build of a test, or the release build."""
    places = [given] if given else [f'{os.environ["HEBRA_BUILD"]}/bench/count_steps'] if 'HEBRA_BUILD' in os.environ \
        else [ROOT / 'build/release/bench/count_steps', ROOT / 'build/portable/bench/count_steps']
    for place in places:
        if os.access(place, os.X_OK):
            return str(place)
    raise Trouble(f'{places[0]} is not there: build it with cmake --preset release && cmake --build build/release')


def compiled_by(path):
    """(compiler with its first number, instruction set) that made the program."""
    about = json.loads(subprocess.run([path], capture_output=True, text=True, check=True).stdout)
    return about['compiler'], about['target']


def run(path, case, isa, options=(), within='count_steps'):
    """Runs one case under callgrind: (its line of JSON, text of the profile). Only what happens within one function
    is collected; isa is the path that the library is to take, whatever this machine can do."""
    with tempfile.TemporaryDirectory() as folder:
        profile = pathlib.Path(folder) / 'profile'
        command = ['valgrind', '--tool=callgrind', f'--toggle-collect={within}', f'--callgrind-out-file={profile}',
                   '--compress-strings=no', '--compress-pos=no', *options, path, *map(str, case)]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, 'HEBRA_ISA': isa})
        if done.returncode != 0 or not profile.exists():
            raise Trouble(f'{" ".join(command)}\nended with status {done.returncode}:\n{done.stderr[-2000:]}')
        return json.loads(done.stdout), profile.read_text()


def totals(profile):
    """Events collected: {'Ir': ..., and with --cache-sim=yes the misses}."""
    names = re.search(r'^events: (.*)$', profile, re.M).group(1).split()
    numbers = re.search(r'^(?:totals|summary): (.*)$', profile, re.M).group(1).split()
    return dict(zip(names, map(int, numbers + ['0'] * (len(names) - len(numbers)))))


def instructions(path, name, isa):
    """Instructions per vertex and step of a case."""
    case = CASES[name]
    about, profile = run(path, case, isa)
    return totals(profile)['Ir'] / (about['vertices'] * case[-1])
