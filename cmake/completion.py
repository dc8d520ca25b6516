#!/usr/bin/env python3
"""Writes shell completion for bash and zsh from the program's own list of options.

    completion.py COMMAND_LINE BASH ZSH   COMMAND_LINE: the program that prints the list;
                                          BASH, ZSH: the files to write
"""

import pathlib
import subprocess
import sys

import command_line

HELP = "help"

BASH = """\
# Completion of orient for bash, generated from the program's options by the build.

# Words that may follow the command $1: subcommands and options.
_orient_words() {{
  case "$1" in
{words}
  esac
}}

# Values of the option $2 of the command $1, none for a file name; fails for a flag.
_orient_values() {{
  case "$1 $2" in
{values}
    *) return 1 ;;
  esac
}}

_orient() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} command="" word values i
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${{COMP_WORDS[i]}}
    case "$word" in
      -*) continue ;;
      help) [ -z "$command" ] && continue ;;
    esac
    [ -n "$(_orient_words "${{command:+$command }}$word")" ] && command=${{command:+$command }}$word
  done
  COMPREPLY=()
  if values=$(_orient_values "$command" "${{COMP_WORDS[COMP_CWORD - 1]}}"); then
    [ -n "$values" ] && COMPREPLY=($(compgen -W "$values" -- "$current"))
    return
  fi
  [[ "$current" == -* || -z "$command" || -n "$(_orient_nested "$command")" ]] &&
    COMPREPLY=($(compgen -W "$(_orient_words "$command")" -- "$current"))
}}

# Subcommands of $1.
_orient_nested() {{
  case "$1" in
{nested}
  esac
}}

complete -o bashdefault -o default -F _orient orient
"""

ZSH = """\
#compdef orient
# Completion of orient for zsh, generated from the program's options by the build.

_orient() {{
  local command="" word
  local -i i
  for ((i = 2; i < CURRENT; i++)); do
    word=$words[i]
    case "${{command:+$command }}$word" in
      ({paths}) command="${{command:+$command }}$word" ;;
    esac
  done
  case "$command" in
{cases}
  esac
}}

_orient "$@"
"""


def bash_text(commands):
    words, values, below = [], [], []
    for path in commands:
        options = command_line.all_options(commands, path)
        names = command_line.nested(commands, path) + ([] if path else [HELP]) + list(options)
        words.append(f'    "{path}") echo "{" ".join(names)}" ;;')
        if command_line.nested(commands, path):
            below.append(f'    "{path}") echo "{" ".join(command_line.nested(commands, path))}" ;;')
        for name, (kind, _) in options.items():
            if kind != "flag":
                listed = "" if kind == "value" else " ".join(kind)
                values.append(f'    "{path} {name}") echo "{listed}" ;;')
    return BASH.format(words="\n".join(words), values="\n".join(values), nested="\n".join(below))


def zsh_quoted(text):
    """Escapes text for single quotes and for _arguments."""
    for special in "\\[]:":
        text = text.replace(special, "\\" + special)
    return text.replace("'", "'\\''")


def zsh_option(name, kind, description):
    value = {"flag": "", "value": ":value:_files"}.get(kind) if isinstance(kind, str) \
        else f":value:({' '.join(kind)})"
    return f"        '{name}[{zsh_quoted(description)}]{value}'"


def zsh_case(commands, path):
    options = command_line.all_options(commands, path)
    lines = [zsh_option(name, *about) for name, about in options.items()]
    below = command_line.nested(commands, path)
    if below:
        summaries = {name: commands[f"{path} {name}".strip()].summary.replace("'", "’")
                     for name in below}
        listed = " ".join(f'{name}\\:"{zsh_quoted(summary)}"'
                          for name, summary in summaries.items())
        lines.append(f"        '*:command:(({listed}))'")
    else:
        lines.append("        '*:file:_files'")
    return f"    ('{path}') _arguments \\\n" + " \\\n".join(lines) + " ;;"


def zsh_text(commands):
    paths = "|".join(f"'{path}'" for path in commands if path)
    cases = "\n".join(zsh_case(commands, path) for path in commands)
    return ZSH.format(paths=paths, cases=cases)


def main(program, bash, zsh):
    listed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    commands = command_line.read(listed)
    pathlib.Path(bash).write_text(bash_text(commands), encoding="utf-8")
    pathlib.Path(zsh).write_text(zsh_text(commands), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
