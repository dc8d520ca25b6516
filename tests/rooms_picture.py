#!/usr/bin/env python3
"""CTest `rooms_picture`: docs/rooms.svg shows which module uses which, according to the includes.

    rooms_picture.py ROOT            fails if the picture does not match the sources under ROOT
    rooms_picture.py ROOT --write    draws it

A module is above all modules that it uses; arrows are includes and point downwards.
"""

import pathlib
import re
import sys

# module: left and right end in units of COLUMN px, purpose, colour.
ROOMS = {
    "tools": (0, 24, "the program: commands, simulator, report, other programs' formats", "#e8e6f4"),
    "block": (1.2, 17, "a whole survey: stages, ties, bundle adjustment, verdict", "#e3edf8"),
    "exterior": (2.4, 8.9, "one photo's pose, from patches", "#fbeede"),
    "patchdb": (0, 7.8, "control patches in a GeoPackage", "#fbe4e2"),
    "interior": (9.7, 18.3, "fiducial marks; from pixel to film", "#e2f3e4"),
    "ortho": (18.8, 23.2, "orthophotos, mosaics", "#f3f0d8"),
    "core": (0, 24, "used by all other modules", "#eeeeec"),
}
NO_ROOM = {"bench"}  # folders that are not part of the product
COLUMN, MARGIN, GAP = 46, 24, 46
PADDING, TITLE, CHIP, CHIP_STEP, LETTER = 14, 40, 24, 30, 6.9
CLEARANCE = 0.35  # of an arrow from whatever it passes, in columns

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


class Plan:
    """Modules (rooms), their folders, and which includes which."""

    def __init__(self, root):
        self.uses = {room: set() for room in ROOMS}
        self.folders = {room: {} for room in ROOMS}  # folder: folders of the module it includes
        for room in ROOMS:
            for source in sorted((root / room).rglob("*.*")):
                path = source.relative_to(root).as_posix().split("/")
                if source.suffix in (".h", ".cpp") and path[1] not in NO_ROOM:
                    self.add(path, source.read_text(encoding="utf-8"))

    def add(self, path, text):
        folder = path[1] if len(path) > 2 else ""
        used = self.folders[path[0]].setdefault(folder, set())
        for header in INCLUDE.findall(text):
            parts = header.split("/")
            if parts[0] != path[0]:
                self.uses[path[0]].add(parts[0])
            elif len(parts) > 2 and parts[1] != folder:
                used.add(parts[1])

    def level_of(self, room):
        return max((self.level_of(other) + 1 for other in self.uses[room]), default=0)

    def folders_of(self, room):
        """The module's folders, each after those that it builds on."""
        inside = {folder: used for folder, used in self.folders[room].items() if folder}

        def level(folder):
            return max((level(other) + 1 for other in inside[folder]), default=0)
        return sorted(inside, key=lambda folder: (level(folder), folder))


def chips(words, width):
    """(word, x, width, line) of words wrapped to lines of a width."""
    placed, x, line = [], 0, 0
    for word in words:
        wide = len(word) * LETTER + 20
        if x and x + wide > width:
            x, line = 0, line + 1
        placed.append((word, x, wide, line))
        x += wide + 8
    return placed


def box(plan, room, top, height):
    left, right, purpose, colour = ROOMS[room]
    x, width = MARGIN + left * COLUMN, (right - left) * COLUMN
    parts = [f'<rect x="{x:.1f}" y="{top}" width="{width:.1f}" height="{height}" rx="10" '
             f'fill="{colour}" stroke="#8a8f98"/>',
             f'<text x="{x + PADDING:.1f}" y="{top + 26}"><tspan class="room">{room}</tspan>'
             f'<tspan class="purpose" dx="12">{purpose}</tspan></text>']
    for word, dx, wide, line in chips(plan.folders_of(room), width - 2 * PADDING):
        left_px, y = x + PADDING + dx, top + TITLE + line * CHIP_STEP
        parts.append(f'<rect x="{left_px:.1f}" y="{y}" width="{wide:.1f}" height="{CHIP}" rx="12" '
                     'fill="#ffffff" stroke="#c4c8ce"/>'
                     f'<text class="folder" x="{left_px + wide / 2:.1f}" y="{y + 16}">{word}</text>')
    return parts


def height_of(plan, room):
    left, right = ROOMS[room][:2]
    lines = [line for *_, line in chips(plan.folders_of(room), (right - left) * COLUMN - 2 * PADDING)]
    return TITLE + (max(lines) + 1) * CHIP_STEP + 8 if lines else TITLE


def column_of(user, used, between, taken):
    """Column of a vertical arrow, as far as possible from whatever it passes."""
    left = max(ROOMS[user][0], ROOMS[used][0])
    right = min(ROOMS[user][1], ROOMS[used][1])
    middle = (left + right) / 2
    free = []
    for step in range(int((right - left) * 10) + 1):
        x = left + step / 10
        room = min([x - left, right - x, 1.5]
                   + [max(ROOMS[other][0] - x, x - ROOMS[other][1]) for other in between]
                   + [abs(x - other) for other in taken])
        if room >= CLEARANCE - 1e-9:
            free.append((-round(room, 3), round(abs(x - middle), 3), x))
    if not free:
        sys.exit(f"no straight way from {user} down to {used}: move their ends in ROOMS")
    return min(free)[2]


def picture(plan):
    level = {room: plan.level_of(room) for room in ROOMS}
    top, at = {}, MARGIN
    for row in range(max(level.values()), -1, -1):
        members = [room for room in ROOMS if level[room] == row]
        height = max(height_of(plan, room) for room in members)
        top.update({room: (at, height) for room in members})
        at += height + GAP
    parts = []
    for room in ROOMS:
        parts += box(plan, room, *top[room])
    taken = []
    arrows = [(level[user] - level[used], user, used) for user in ROOMS for used in plan.uses[user]]
    for _, user, used in sorted(arrows, reverse=True):  # the longest have the least choice
        between = [room for room in ROOMS if level[used] < level[room] < level[user]]
        column = column_of(user, used, between, taken)
        taken.append(column)
        x = MARGIN + column * COLUMN
        parts.append(f'<path d="M{x:.1f} {sum(top[user])} V{top[used][0] - 11}" class="use"/>')
    width = 2 * MARGIN + max(room[1] for room in ROOMS.values()) * COLUMN
    return HEAD.format(width=width, height=at - GAP + MARGIN) + "\n".join(parts) + "\n</svg>\n"


HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" \
width="{width}" height="{height}" font-family="Helvetica, Arial, sans-serif">
<!-- drawn by tests/rooms_picture.py from the includes -->
<style>
.room {{ font-size: 18px; font-weight: bold; fill: #22262c }}
.purpose {{ font-size: 13px; fill: #5a616b }}
.folder {{ font-size: 13px; fill: #22262c; text-anchor: middle }}
.use {{ stroke: #5a616b; stroke-width: 1.6; fill: none; marker-end: url(#tip) }}
</style>
<defs><marker id="tip" viewBox="0 0 10 10" refX="2" refY="5" markerWidth="8" markerHeight="8" \
orient="auto"><path d="M0 0 L10 5 L0 10 z" fill="#5a616b"/></marker></defs>
<rect width="100%" height="100%" fill="#ffffff"/>
"""


def main(words):
    if len(words) not in (1, 2) or words[1:] not in ([], ["--write"]):
        print(__doc__)
        return 2
    root = pathlib.Path(words[0])
    file = root / "docs/rooms.svg"
    drawn = picture(Plan(root))
    if words[1:]:
        file.write_text(drawn, encoding="utf-8")
    elif not file.exists() or file.read_text(encoding="utf-8") != drawn:
        print("docs/rooms.svg does not match the includes: check them, then draw it again with\n"
              "tests/rooms_picture.py . --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
