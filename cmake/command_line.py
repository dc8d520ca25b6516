"""What `orient_command_line` (tools/completion) prints: commands and options of the program."""

import collections

# options: name -> (kind, description); kind: "flag", "value", or a list of the possible values.
Command = collections.namedtuple("Command", "path summary options")


def read(text):
    """path -> Command, in the program's order; "" is the program itself."""
    commands = {}
    for line in text.splitlines():
        what, path, *fields = line.split("\t")
        if what == "command":
            commands[path] = Command(path, fields[0], {})
        else:
            name, kind, description = fields
            commands[path].options[name] = (kind if kind in ("flag", "value") else kind.split(),
                                            description)
    return commands


def nested(commands, path):
    """Names of the commands directly below."""
    begin = path + " " if path else ""
    return [other[len(begin):] for other in commands
            if other and other.startswith(begin) and other != path
            and " " not in other[len(begin):]]


def all_options(commands, path):
    """Those of the command and of the one above it, which it takes as well (`--verbose`)."""
    above = path.rpartition(" ")[0] if " " in path else None
    inherited = commands[above].options if above else {}
    return {**commands[path].options, **inherited}
