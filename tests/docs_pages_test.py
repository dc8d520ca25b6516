#!/usr/bin/env python3
"""CTest `docs_pages`: every subcommand has its page, and the page knows every option.

    docs_pages_test.py ORIENT DOCS   ORIENT: the program; DOCS: the folder of the pages

What the help of `orient NAME` (and of its nested commands) lists must be mentioned in DOCS/NAME.md.
"""

import pathlib
import re
import subprocess
import sys

OPTION = re.compile(r"--[a-z][a-z0-9-]*")
# These say the same everywhere; docs/README.md explains them once.
EVERYWHERE = {"--help", "--verbose"}


def help_of(program, words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True,
                          text=True).stdout


def commands_in(text):
    """Names below the heading "Subcommands:"."""
    _, _, listed = text.partition("Subcommands:\n")
    names = []
    for line in listed.splitlines():
        match = re.match(r"  ([a-z][a-z-]*)(\s|$)", line)
        if match:
            names.append(match[1])
        elif line.strip() == "":
            break
    return names


def complaints_about(program, words, page):
    text = help_of(program, words)
    name = " ".join(["orient", *words])
    found = [f"{page.name} does not mention {option} of `{name}`"
             for option in sorted(set(OPTION.findall(text.partition("Subcommands:")[0])))
             if option not in EVERYWHERE and not mentions(page, option)]
    for nested in commands_in(text):
        if not mentions(page, nested):
            found.append(f"{page.name} does not mention `{name} {nested}`")
        found += complaints_about(program, [*words, nested], page)
    return found


def mentions(page, word):
    return re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", page.read_text(encoding="utf-8"))


def main(program, docs):
    found = []
    names = commands_in(help_of(program, []))
    if not names:
        found.append("`orient --help` lists no subcommand")
    for name in names:
        page = pathlib.Path(docs) / f"{name}.md"
        if page.exists():
            found += complaints_about(program, [name], page)
        else:
            found.append(f"{page}: the page of `orient {name}` is missing")
    print("\n".join(found) or f"{len(names)} pages know every option")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
