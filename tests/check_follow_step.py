#!/usr/bin/env python3
"""What the documents say of the sources is so:  tests/check_follow_step.py [ROOT]

In every file of docs/ and in README.md and CONTRIBUTING.md, where they exist:
- a function named with its file, `name` (`path`), is defined in that file,
- every `path` into the tree and every relative link leads somewhere, also to headings (files that an example adds are
  named in its <!-- new: PATH --> lines),
- every `hb_...` and `HB_...` name occurs in the sources,
- code below a line  <!-- file: PATH -->  is that file,
- C files in docs/ compile without a warning (names that an example adds come from its <!-- define: ... --> line).
follow-one-step.md has to name the functions that the step calls: those are listed from the sources. If HEBRA is set to the
program, docs/guide/commands.md has to name exactly the options that `hebra VERB --help` names.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

TREE = ('src', 'include', 'cli', 'tests', 'tools', 'scenes', 'docs', 'cmake', 'bench')
PAIR = re.compile(r'`(\w+)`\s*\(`([\w.-]+/[\w./-]+)`\)')
QUOTED = re.compile(r'(?<!`)`([^`\n]+)`(?!`)')
LINK = re.compile(r'(?<!!)\[[^\]]*\]\(([^)\s]+)\)')
SHOWN = re.compile(r'<!-- file: (\S+) -->\s*```\w*\n(.*?)```', re.S)
MATH = re.compile(r'\$\$.*?\$\$|\$[^$\n]+\$', re.S)
FENCED = re.compile(r'^```.*?^```', re.S | re.M)
STEP = 'docs/develop/follow-one-step.md'
COMMANDS = 'docs/guide/commands.md'
# Who calls what in a step: every hb_ function of these is to be found in follow-one-step.md.
CALLERS = (('src/sim/step.c', 'hb_sim_step'), ('src/time/verlet.c', 'step_rod'),
           ('src/time/stepper.c', 'hb_stepper_evaluate'), ('src/rod/evaluate.c', 'hb_rod_settle'),
           ('src/rod/evaluate.c', 'hb_rod_force'))
SMALL = {'hb_stepper_begin', 'hb_stepper_end', 'hb_fail'}  # the stage clock and the failure sentence


def defines(text, name):
    """Is a function or a macro of this name defined in C text?"""
    if re.search(r'^#define %s\(' % re.escape(name), text, re.M):
        return True
    for match in re.finditer(r'^(?!\s)[\w][^\n;{}()]*\b%s\s*\(' % re.escape(name), text, re.M):
        depth = 0
        for at in range(match.end() - 1, len(text)):
            depth += (text[at] == '(') - (text[at] == ')')
            if depth == 0:
                if text[at + 1:].lstrip().startswith('{'):
                    return True
                break
    return False


def body(text, name):
    """Text of a function's body: to the closing brace in column 1."""
    match = re.search(r'^(?!\s)[^\n;{}()]*\b%s\s*\([^{;]*\{(.*?)^\}' % re.escape(name), text, re.S | re.M)
    return match.group(1) if match else ''


def headings(text):
    """Anchors of a document's headings, as GitHub makes them."""
    found = re.findall(r'^#+ +(.+?) *$', FENCED.sub('', text), re.M)
    return {re.sub(r'[^\w\- ]', '', h.lower()).replace(' ', '-') for h in found}


class Check:
    """Counts what is looked at and what is wrong."""

    def __init__(self, root):
        self.root, self.wrong, self.looked = root, 0, 0
        self.sources = '\n'.join(p.read_text(errors='replace') for top in ('src', 'include', 'cli', 'tests')
                                 for p in sorted((root / top).rglob('*.[ch]')))

    def judge(self, good, place, what):
        """One thing looked at."""
        self.looked += 1
        if not good:
            self.wrong += 1
            print(f'{place}: {what}')

    def pairs(self, place, text):
        """`name` (`path`)"""
        for name, path in PAIR.findall(text):
            file = self.root / path
            good = file.is_file() and defines(file.read_text(), name)
            self.judge(good, place, f'{name} is not defined in {path}' if file.is_file() else f'there is no file {path}')

    def names(self, place, text):
        """Quoted paths and names."""
        new = re.findall(r'<!-- new: (\S+) -->', text)
        for quoted in QUOTED.findall(text):
            if re.fullmatch(r'(%s)/[\w./-]+' % '|'.join(TREE), quoted) and not re.search(r'NAME|DIR', quoted):
                self.judge(quoted in new or (self.root / quoted).exists(), place, f'there is no {quoted}')
            for name in re.findall(r'\b(?:hb|HB|cli)_\w+', quoted):
                self.judge(re.search(r'\b%s' % name, self.sources), place, f'{name} does not occur in the sources')

    def links(self, place, text, file):
        """[text](target#heading)"""
        plain = MATH.sub('', QUOTED.sub('', FENCED.sub('', text)))
        for target in LINK.findall(plain):
            if re.match(r'[a-z]+:', target):
                continue
            path, _, anchor = target.partition('#')
            other = (file.parent / path) if path else file
            self.judge(other.exists(), place, f'the link {target} leads nowhere')
            if anchor and other.suffix == '.md' and other.is_file():
                self.judge(anchor in headings(other.read_text()), place, f'{path or "this document"} has no heading #{anchor}')

    def shown(self, place, text):
        """Code that is said to be a file."""
        for path, code in SHOWN.findall(text):
            file = self.root / path
            self.judge(file.is_file() and file.read_text() == code, place, f'the code shown is not that of {path}')

    def step(self):
        """The functions that a step calls are in the walk-through."""
        text = (self.root / STEP).read_text()
        for path, name in CALLERS:
            inside = body((self.root / path).read_text(), name)
            self.judge(inside, path, f'{name} is not there; CALLERS in tests/check_follow_step.py has to be mended')
            for called in sorted(set(re.findall(r'\b(hb_\w+)\s*\(', inside)) - SMALL):
                self.judge(f'`{called}`' in text, STEP, f'{called}, which {name} calls, is not named')

    def options(self, program):
        """Options of every verb: the program's help against the guide."""
        text = (self.root / COMMANDS).read_text()
        overview = subprocess.run([program, '--help'], capture_output=True, text=True).stdout
        verbs = re.findall(r'^  ([a-z]+) {2,}\S', overview, re.M)
        self.judge(verbs, COMMANDS, 'hebra --help names no verbs')
        for verb in verbs:
            said = subprocess.run([program, verb, '--help'], capture_output=True, text=True).stdout
            section = re.search(r'^## %s$(.*?)(?=^## |\Z)' % verb, text, re.S | re.M)
            self.judge(section, COMMANDS, f'there is no section on {verb}')
            known = set(re.findall(r'(?<![\w-])--?[a-z]+', said)) - {'-'}
            told = set(re.findall(r'(?<![\w-])--?[a-z]+', section.group(1))) if section else set()
            for option in sorted(known - told):
                self.judge(False, COMMANDS, f'{option} of {verb} is missing')
            for option in sorted(told - known):
                self.judge(False, COMMANDS, f'{verb} has no {option}')
            self.looked += len(known)

    def examples(self):
        """C files in docs/ compile."""
        compiler = shutil.which('cc') or shutil.which('gcc') or shutil.which('clang')
        if not compiler:
            print('no C compiler: the examples are not compiled')
            return
        texts = '\n'.join(p.read_text() for p in (self.root / 'docs').rglob('*.md'))
        defines_ = ['-D' + d for d in re.findall(r'<!-- define: (\S+) -->', texts)]
        for file in sorted((self.root / 'docs').rglob('*.c')):
            if file.name.startswith('test_'):
                if not pathlib.Path('/usr/include/cmocka.h').exists():
                    continue
            command = [compiler, '-std=c17', '-D_POSIX_C_SOURCE=200809L', '-fsyntax-only', '-Wall', '-Wextra', '-Wpedantic',
                       '-Wshadow', '-Wconversion', '-Wno-sign-conversion', '-Werror', '-I', 'include', '-I', 'src', '-I', 'tests']
            # First as it is: somebody may have followed the example and added what it adds.
            for extra in ([], defines_):
                done = subprocess.run(command + extra + [str(file)], cwd=self.root, capture_output=True, text=True)
                if done.returncode == 0:
                    break
            self.judge(done.returncode == 0, file.relative_to(self.root), 'does not compile:\n' + done.stderr)


def main():
    """Checks every document; status 1 and a line each if one is wrong."""
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent).resolve()
    check = Check(root)
    files = sorted((root / 'docs').rglob('*.md')) + [p for p in (root / 'README.md', root / 'CONTRIBUTING.md') if p.exists()]
    for file in files:
        text, place = file.read_text(), file.relative_to(root)
        check.pairs(place, text)
        check.names(place, FENCED.sub('', text))
        check.links(place, text, file)
        check.shown(place, text)
    check.step()
    check.examples()
    if os.environ.get('HEBRA'):
        check.options(os.environ['HEBRA'])
    print(f'{len(files)} documents, {check.looked} statements, {check.wrong} wrong')
    return 1 if check.wrong or not files or check.looked < 100 else 0


sys.exit(main())
