"""The program's commands and options, as listed by `orient_command_line` (tools/completion)."""

import collections

# options: name -> (kind, description); kind: "flag", "value", or a list of the possible values.
Command = collections.namedtuple("Command", "path summary options")


def read(text):
    """Returns path -> Command, in the program's order; "" is the program itself."""
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
    """Names of the subcommands directly below `path`."""
    begin = path + " " if path else ""
    return [other[len(begin):] for other in commands
            if other and other.startswith(begin) and other != path
            and " " not in other[len(begin):]]


def all_options(commands, path):
    """Options of the command and those inherited from its parent (`--verbose`)."""
    above = path.rpartition(" ")[0] if " " in path else None
    inherited = commands[above].options if above else {}
    return {**commands[path].options, **inherited}
