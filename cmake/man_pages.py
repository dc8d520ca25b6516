#!/usr/bin/env python3
"""Writes man pages from the pages in docs, one for the program and one for each subcommand.

    man_pages.py COMMAND_LINE DOCS VERSION OUT   COMMAND_LINE: the program that prints commands and
                                                 options; OUT: a folder for orient.1.gz, ...

Converts the Markdown that these pages use: headings, paragraphs, lists, tables, code, links and
emphasis. A table becomes a list with its first column as the terms.
"""

import gzip
import pathlib
import re
import subprocess
import sys

import command_line

LINK = re.compile(r"!?\[([^\]]*)\]\(([^)\s]*)\)")
INLINE = re.compile(r"(``.+?``|`[^`]*`|\*\*.+?\*\*|(?<![\w*])\*[^*\s][^*]*\*(?![\w*]))")
WHERE = "/usr/share/doc/orient"


def plain(text):
    """Escapes text that roff would interpret."""
    return text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")


def line_of(text):
    """Escapes the beginning of a line that looks like a roff request."""
    return "\\&" + text if text.startswith((".", "'")) else text


def inline(text):
    """Converts code and strong emphasis to bold, emphasis to italic, and links to their text."""
    text = LINK.sub(r"\1", text)
    parts = []
    for part in INLINE.split(text):
        if part.startswith("`"):
            parts.append(f"\\fB{plain(part.strip('`').strip())}\\fR")
        elif part.startswith("**"):
            parts.append(f"\\fB{plain(part[2:-2].replace('`', ''))}\\fR")
        elif len(part) > 2 and part.startswith("*") and part.endswith("*"):
            parts.append(f"\\fI{plain(part[1:-1])}\\fR")
        else:
            parts.append(plain(part))
    return line_of("".join(parts))


def section(title):
    return ".SH " + plain(LINK.sub(r"\1", title).replace("`", "").upper())


def told_links(text, names):
    """Adds to links to other pages their targets: a man page, or a file of the documentation.
    `names`: the commands that have a man page."""
    def told(match):
        words, page = match[1], match[2].partition("#")[0]
        if not page.endswith(".md") or page.startswith("../.."):
            return words
        name = page[:-len(".md")]
        leads_to = f"orient-{name}(1)" if name in names else page
        return leads_to if words.strip("`") in (name, f"orient {name}") else f"{words} ({leads_to})"
    return LINK.sub(told, text)


def code(lines):
    return [".PP", ".RS 4", ".nf", *[line_of(plain(line)) for line in lines], ".fi", ".RE"]


def cells_of(row):
    """Cells of a table row; in `a\\|b` the bar separates no cells."""
    return [cell.replace("\\|", "|").strip()
            for cell in re.split(r"(?<!\\)\|", row.strip().strip("|"))]


def table(rows):
    """The first column becomes the term; if several others follow, their headings label them."""
    head, *body = [cells_of(row) for row in rows if not re.fullmatch(r"[\s|:-]+", row)]
    out = []
    for row in body:
        rest = [(name, cell) for name, cell in zip(head[1:], row[1:]) if cell]
        told = [cell if len(head) == 2 or not name else f"{name}: {cell}" for name, cell in rest]
        out += [".TP", inline(row[0]) or "\\&", inline("; ".join(told)) or "\\&"]
    return out


def blocks_of(text):
    """Splits a page into (kind, lines): heading, code, table, list item, paragraph."""
    found, fence = [], False
    for line in text.splitlines():
        kind = found[-1][0] if found else None
        if line.lstrip().startswith("```"):
            fence = not fence
            found.append(("code", []) if fence else ("end", []))
        elif fence:
            found[-1][1].append(line)
        elif re.match(r"#+ ", line):
            found.append(("heading", [line]))
        elif line.startswith("|"):
            if kind != "table":
                found.append(("table", []))
            found[-1][1].append(line)
        elif item := re.match(r"\s*(?:[-*]|\d+\.) (.*)", line):
            found.append(("item", [item[1]]))
        elif not line.strip():
            found.append(("end", []))
        elif kind in ("item", "paragraph"):
            found[-1][1].append(line.strip())
        else:
            found.append(("paragraph", [line]))
    return [(kind, lines) for kind, lines in found if kind != "end"]


def roff(kind, lines):
    if kind == "heading":
        level, _, title = lines[0].partition(" ")
        return [section(title) if len(level) == 2 else f".SS {inline(title)}"]
    if kind == "code":
        return code(lines)
    if kind == "table":
        return table(lines)
    if kind == "item":
        return [".IP \\(bu 2", inline(" ".join(lines))]
    return [".PP", inline(" ".join(lines))]


def sections_of(text):
    """Splits a page into (title or "", blocks), without its main heading."""
    sections = [("", [])]
    for kind, lines in blocks_of(text):
        if kind == "heading" and lines[0].startswith("# "):
            continue
        if kind == "heading" and lines[0].startswith("## "):
            sections.append((lines[0][3:], []))
        else:
            sections[-1][1].append((kind, lines))
    return sections


def in_order(sections, command):
    """Sections in the order of man pages; text before the first heading is the description."""
    intro = sections[0][1]
    rest = dict(sections[1:])
    synopsis = rest.pop("Synopsis", [("code", [f"orient {command} [OPTIONS]"])])
    return ([("Synopsis", synopsis), ("Description", intro + rest.pop("Description", []))]
            + list(rest.items()))


def head_of(name, summary, version):
    return [f'.TH {name.upper()} 1 "" "orient {version}" "User Commands"', ".SH NAME",
            f"{plain(name)} \\- {plain(summary)}"]


def see_also(commands, name):
    others = ["orient"] + [f"orient-{other}" for other in command_line.nested(commands, "")]
    listed = ", ".join(f"\\fB{plain(other)}\\fR(1)" for other in others if other != name)
    return [".SH SEE ALSO", listed, ".PP",
            f"The files named here, methods and evidence among them, are in {plain(WHERE)}."]


def page_of(commands, command, text, version):
    name = f"orient-{command}"
    lines = head_of(name, commands[command].summary, version)
    text = told_links(text, command_line.nested(commands, ""))
    for title, blocks in in_order(sections_of(text), command):
        lines.append(section(title))
        for block in blocks:
            lines += roff(*block)
    return "\n".join(lines + see_also(commands, name)) + "\n"


def program_page(commands, text, version):
    """orient(1): its commands, and the first section of docs/README.md, which applies to all."""
    lines = head_of("orient", "orients scans of aerial film photos", version)
    lines += [".SH SYNOPSIS", "\\fBorient\\fR \\fICOMMAND\\fR ...", ".SH DESCRIPTION",
              plain(commands[""].summary), ".SH COMMANDS"]
    for name in command_line.nested(commands, ""):
        lines += [".TP", f"\\fB{plain(name)}\\fR, see \\fB{plain('orient-' + name)}\\fR(1)",
                  plain(commands[name].summary)]
    lines.append(".SH OPTIONS OF EVERY COMMAND, AND EXIT CODES")
    for block in sections_of(text)[0][1]:
        lines += roff(*block)
    return "\n".join(lines + see_also(commands, "orient")) + "\n"


def main(program, docs, version, out):
    listed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    commands = command_line.read(listed)
    docs, out = pathlib.Path(docs), pathlib.Path(out)
    pages = {"orient": program_page(commands, (docs / "README.md").read_text("utf-8"), version)}
    for name in command_line.nested(commands, ""):
        text = (docs / f"{name}.md").read_text("utf-8")
        pages[f"orient-{name}"] = page_of(commands, name, text, version)
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("*.1.gz"):
        old.unlink()
    for name, text in pages.items():  # mtime=0: the same bytes every time
        (out / f"{name}.1.gz").write_bytes(gzip.compress(text.encode("utf-8"), 9, mtime=0))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 5 else __doc__)
