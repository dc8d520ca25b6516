#!/usr/bin/env python3
"""CTest `docs_pages`: every subcommand has its page, and all pages are readable and linked.

    docs_pages_test.py ORIENT DOCS   ORIENT: the program; DOCS: the folder of the pages
    docs_pages_test.py --self-test   checks that each kind of fault is found

All that the help of `orient NAME` (and of its nested commands) lists must be mentioned in
DOCS/NAME.md. Pages have at most MOST_LINES lines of MOST_COLUMNS columns (tables and code may be
wider) and use the terms of the field. Every relative link in them, and in README.md and
CONTRIBUTING.md beside DOCS, leads to a file, and to a heading if it names one. Every page can be
reached from DOCS/README.md or README.md.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

OPTION = re.compile(r"--[a-z][a-z0-9-]*")
# The same for every command; docs/README.md explains them once.
EVERYWHERE = {"--help", "--verbose", "--quiet", "--log", "--log-json"}

MOST_LINES = 200
MOST_COLUMNS = 100
# Phrases for which the glossary in conventions.md has a better term.
FORBIDDEN = ("came to rest", "come to rest", "comes to rest", "way of lying", "ways of lying",
             "freed")

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def help_of(program, words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True,
                          text=True).stdout


def commands_in(text):
    """Names listed under the heading "Subcommands:"."""
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


def complaints_about_commands(program, docs):
    names = commands_in(help_of(program, []))
    found = [] if names else ["`orient --help` lists no subcommand"]
    for name in names:
        page = docs / f"{name}.md"
        if page.exists():
            found += complaints_about(program, [name], page)
        else:
            found.append(f"{page}: the page of `orient {name}` is missing")
    return found


def prose_of(text):
    """(line number, line) of everything outside fenced code."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line


def complaints_about_form(page):
    text = page.read_text(encoding="utf-8")
    lines = len(text.splitlines())
    found = []
    if lines > MOST_LINES:
        found.append(f"{page}: {lines} lines, more than {MOST_LINES}: split it")
    for number, line in prose_of(text):
        if len(line) > MOST_COLUMNS and not line.startswith("|"):
            found.append(f"{page}:{number}: {len(line)} columns, more than {MOST_COLUMNS}")
    # A phrase may continue on the next line.
    words = " ".join(text.lower().split())
    found += [f'{page}: says "{phrase}"; the glossary has a better word'
              for phrase in FORBIDDEN if re.search(rf"\b{phrase}\b", words)]
    return found


def anchors_of(page):
    """Anchors of the headings, as GitHub generates them."""
    anchors = set()
    for _, line in prose_of(page.read_text(encoding="utf-8")):
        match = re.match(r"#+ (.*)", line)
        if match:
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match[1]).strip().lower()
            anchors.add(re.sub(r"[^\w\- ]", "", title).replace(" ", "-"))
    return anchors


def links_of(page):
    """(link as written, file, anchor or "") of the relative links."""
    prose = "\n".join(line for _, line in prose_of(page.read_text(encoding="utf-8")))
    for link in LINK.findall(re.sub(r"`[^`]*`", "code", prose)):
        if not re.match(r"[a-z]+:", link):
            path, _, anchor = link.partition("#")
            yield link, (page.parent / path).resolve() if path else page, anchor


def complaints_about_links(page):
    found = []
    for link, target, anchor in links_of(page):
        if not target.exists():
            found.append(f"{page}: ({link}) leads to no file")
        elif anchor and anchor not in anchors_of(target):
            found.append(f"{page}: ({link}) leads to no heading")
    return found


def reached_from(starts):
    reached, todo = set(), [start for start in starts if start.exists()]
    while todo:
        page = todo.pop()
        if page not in reached:
            reached.add(page)
            todo += [target for _, target, _ in links_of(page)
                     if target.suffix == ".md" and target.exists()]
    return reached


def complaints_about_pages(docs):
    beside = [docs.parent / name for name in ("README.md", "CONTRIBUTING.md")]
    pages = sorted(docs.rglob("*.md"))
    found = []
    for page in pages + [page for page in beside if page.exists()]:
        found += complaints_about_form(page) + complaints_about_links(page)
    reached = reached_from([docs / "README.md", beside[0]])
    return found + [f"{page}: no link leads here" for page in pages if page not in reached]


def main(program, docs):
    docs = pathlib.Path(docs).resolve()
    found = complaints_about_commands(program, docs) + complaints_about_pages(docs)
    print("\n".join(found) or f"{len(list(docs.rglob('*.md')))} pages are in order")
    return 1 if found else 0


GOOD = {"README.md": "[docs](docs/README.md)\n",
        "docs/README.md": "[a](a.md), [its end](a.md#the-end-of-it)\n",
        "docs/a.md": "# A\n\n## The `end` of it\n\n[up](#a)\n\n```\n[no link](nowhere.md)\n```\n"
                     f"\n| {'wide ' * 30}|\n"}
# file, text added to it, expected complaint
FAULTS = [("docs/a.md", "more\n" * MOST_LINES, "split it"),
          ("docs/a.md", "wide " * 30, "columns, more than"),
          ("docs/a.md", "It came\nto rest.", "better word"),
          ("docs/a.md", "[x](b.md)", "leads to no file"),
          ("README.md", "[x](docs/a.md#the-middle)", "leads to no heading"),
          ("docs/evidence/b.md", "# B", "no link leads here")]


def said_of(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = pathlib.Path(folder).resolve() / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return complaints_about_pages(pathlib.Path(folder).resolve() / "docs")


def self_test():
    wrong = [f"good pages: {said}" for said in said_of(GOOD)]
    for name, text, expected in FAULTS:
        said = said_of({**GOOD, name: GOOD.get(name, "") + "\n" + text + "\n"})
        if len(said) != 1 or expected not in said[0]:
            wrong.append(f'{name} with "{text[:20]}": expected one "... {expected}", not {said}')
    print("\n".join(wrong) or f"{len(FAULTS)} faults are found")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(self_test() if sys.argv[1:] == ["--self-test"] else main(*sys.argv[1:]))
