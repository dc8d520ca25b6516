#!/usr/bin/env python3
"""CTest `manuals`: man pages and shell completion are complete and match the program.

    manuals_test.py COMMAND_LINE SCRIPTS DOCS   COMMAND_LINE: the program that prints the options;
                                                SCRIPTS: the folder of man_pages.py, completion.py
    manuals_test.py --self-test SCRIPTS         converts an example page

Completion by bash is tested with typical beginnings of commands; zsh and groff, if installed, check
the syntax of their files.
"""

import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Traces of Markdown that was not converted.
RESIDUE = re.compile(r"```|\]\(|\*\*|^\||^#|`")
GROFF = ("groff", "-man", "-t", "-K", "utf8", "-T", "utf8", "-ww", "-z")

# Words typed (the last one is being completed), what must be offered, what must not be offered.
TYPED = [
    (["orient", ""], {"interior", "block", "help", "--version"}, {"--resume"}),
    (["orient", "pat"], {"patchdb"}, {"block"}),
    (["orient", "help", "ex"], {"exterior"}, {"block"}),
    (["orient", "block", "--re"], {"--resume"}, {"--quiet"}),
    (["orient", "block", "b.toml", "--"], {"--learn", "--quiet", "--log"}, {"--crs"}),
    (["orient", "patchdb", "harvest-"], {"harvest-ortho"}, {"harvest"}),
    (["orient", "patchdb", "create", "a.gpkg", "--"], {"--crs", "--verbose"}, {"--learn"}),
    (["orient", "interior", "--polarity", ""], {"auto", "positive", "negative"}, {"interior"}),
    (["orient", "interior", "--polarity", "po"], {"positive"}, {"negative"}),
    (["orient", "exterior", "--dem", ""], set(), {"--dem", "auto", "exterior"}),  # a file
]


def offered(script, words):
    """Completions in bash; file names are left to bash itself."""
    quoted = " ".join(f"'{word}'" for word in words)
    text = (f"source '{script}'; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _orient; "
            "printf '%s\\n' \"${COMPREPLY[@]}\"")
    done = subprocess.run(["bash", "--norc", "-c", text],
                          capture_output=True, text=True, check=False)
    if done.stderr:
        return {done.stderr}
    return set(done.stdout.split())


def complaints_about_bash(script):
    found = []
    for words, wanted, unwanted in TYPED:
        got = offered(script, words)
        if not wanted <= got or got & unwanted:
            found.append(f"bash: '{' '.join(words)}' offers {sorted(got)}")
    return found


def complaints_about_zsh(script, commands, command_line):
    text = script.read_text(encoding="utf-8")
    found = [f"zsh: {name} of '{path}' is missing" for path in commands
             for name in command_line.all_options(commands, path) if f"'{name}[" not in text]
    if shutil.which("zsh") is None:
        print("zsh is not installed: only the names in its file are checked")
        return found
    done = subprocess.run(["zsh", "-n", script], capture_output=True, text=True, check=False)
    return found + ([f"zsh: {done.stderr}"] if done.returncode else [])


def complaints_about_page(page, text):
    prose = re.sub(r"\n\.nf\n.*?\n\.fi\n", "\n", text, flags=re.DOTALL)
    found = [f"{page}: Markdown is left: {line}" for line in prose.splitlines()
             if RESIDUE.search(line)]
    for section in (".SH NAME", ".SH SYNOPSIS", ".SH DESCRIPTION", ".SH SEE ALSO"):
        if text.count(section + "\n") != 1:
            found.append(f"{page}: not one {section}")
    if shutil.which("groff"):
        said = subprocess.run(GROFF, input=text, capture_output=True, text=True, check=False).stderr
        found += [f"{page}: {line}" for line in said.splitlines()
                  if "cannot adjust line" not in line and "can't break line" not in line]
    return found


def complaints_about_man(folder, commands, command_line):
    names = [f"orient-{name}" for name in command_line.nested(commands, "")]
    found = []
    if {page.name for page in folder.iterdir()} != {f"{n}.1.gz" for n in ["orient", *names]}:
        found.append(f"man: there are {sorted(page.name for page in folder.iterdir())}")
    for name in ["orient", *names]:
        text = gzip.decompress((folder / f"{name}.1.gz").read_bytes()).decode("utf-8")
        found += complaints_about_page(name, text)
        path = name.partition("-")[2]
        for option in commands[path].options if path else []:
            everywhere = option in ("--help", "--verbose", "--quiet", "--log", "--log-json")
            if not everywhere and option.replace("-", "\\-") not in text:
                found.append(f"{name}.1: {option} is missing")
    return found


def main(program, scripts, docs):
    sys.path.insert(0, scripts)
    import command_line
    listed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    commands = command_line.read(listed)
    with tempfile.TemporaryDirectory() as temporary:
        out = pathlib.Path(temporary)
        for script, *arguments in (("man_pages.py", docs, "0", out / "man"),
                                   ("completion.py", out / "bash", out / "zsh")):
            subprocess.run([sys.executable, f"{scripts}/{script}", program, *arguments], check=True)
        found = (complaints_about_man(out / "man", commands, command_line)
                 + complaints_about_bash(out / "bash")
                 + complaints_about_zsh(out / "zsh", commands, command_line))
    print("\n".join(found) or f"{len(commands)} commands have their manuals and are completed")
    return 1 if found else 0


COMMANDS = "command\t\tOrients\ncommand\tstore\tKeep - 'things'\noption\tstore\t--out\tvalue\tWhere\n"
PAGE = """# orient store

Keeps `a-b\\c` and **all**, see [that](other.md#x) and [`orient store`](store.md).
.begins like a request

## Options

| option | meaning |
|---|---|
| `--out` | where `a\\|b` goes |

| key | from | to |
|---|---|---|
| k | a | b |

## Synopsis

```
orient store --out [DIR]
.x
```

- one
  line
"""
EXPECTED = """.SH NAME
orient\\-store \\- Keep \\- \\(aqthings\\(aq
.SH SYNOPSIS
.PP
.RS 4
.nf
orient store \\-\\-out [DIR]
\\&.x
.fi
.RE
.IP \\(bu 2
one line
.SH DESCRIPTION
.PP
Keeps \\fBa\\-b\\ec\\fR and \\fBall\\fR, see that (other.md) and orient\\-store(1). .begins like a request
.SH OPTIONS
.TP
\\fB\\-\\-out\\fR
where \\fBa|b\\fR goes
.TP
k
from: a; to: b
.SH SEE ALSO
"""


def self_test(scripts):
    sys.path.insert(0, scripts)
    import command_line
    import man_pages
    text = man_pages.page_of(command_line.read(COMMANDS), "store", PAGE, "0")
    found = [] if EXPECTED in text else [f"expected\n{EXPECTED}\nnot\n{text}"]
    if not complaints_about_page("page", text.replace(".SH NAME", ".SH NAME\n| a [b](c) |")):
        found.append("Markdown that is left is not noticed")
    print("\n".join(found) or "the made-up page is converted")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(self_test(sys.argv[2]) if sys.argv[1:2] == ["--self-test"] else main(*sys.argv[1:]))
