"""Orient in Python: run its commands, read their results, and transform between scan and ground.

    import orient

    orient.run("block", "block.toml", progress=print)
    block = orient.Block("out")
    print(block.names, block.statuses, block.positions)
    geometry = block.geometry("4711")
    pixels = geometry.pixels(ground)            # (n, 3) metres in the block's CRS -> (n, 2)
    ground = geometry.ground(pixels, orient.Surface("dem.tif", block.crs))

Everything here is the program's own: the commands are those of `orient`, the numbers come from its
result files, and the projection is that of the adjustment. Coordinates, angles (radians) and pixels
are defined in docs/conventions.md; missing values are NaN in arrays and None elsewhere.
"""

import json
import os
import pathlib
from collections.abc import Iterable
from typing import Any, Callable, Iterator, NamedTuple, Optional, Union

import numpy as np

from ._native import (ExteriorResult, Finding, InputError, InteriorResult, MachineError,
                      PhotoGeometry, Surface, UsageError)
from . import _native

Path = Union[str, bytes, os.PathLike]

__version__: str = _native.version
__all__ = ["Block", "ExteriorResult", "Finding", "InputError", "InteriorResult", "MachineError",
           "PhotoGeometry", "Poses", "Run", "Surface", "UsageError", "read_exterior",
           "read_interior", "read_poses", "run"]


class Run(NamedTuple):
    """Output of a command. `all_done` is False if some photos were not oriented."""

    all_done: bool
    output: str  # standard output
    messages: str  # standard error


def run(command: str, *arguments: Any, progress: Optional[Callable[[str, int, int], Any]] = None,
        **options: Any) -> Run:
    """Runs `orient COMMAND ARGUMENTS --OPTIONS` in this process.

    `pixel_size_um=20` is --pixel-size-um 20, `overwrite=True` the flag, a list several values.
    Nested commands are arguments: run("patchdb", "create", "p.gpkg", crs="EPSG:32635").
    `progress(task, done, total)` is called in this thread while the command runs. An exception that
    it raises, or Ctrl-C, ends the command at its next step; finished results are kept.

    Raises UsageError, InputError or MachineError if the program would exit with 1, 2 or 4.
    """
    if command == "review":
        raise UsageError("orient review serves until it is stopped: run it from a shell")
    words = [command, *map(_word, arguments)]
    for name, value in options.items():
        words += _option("--" + name.rstrip("_").replace("_", "-"), value)
    code, output, messages = _native.run(words, progress)
    refusal = {1: UsageError, 2: InputError, 4: MachineError}.get(code)
    if refusal:
        raise refusal(messages.strip().removeprefix("orient: "))
    return Run(code == 0, output, messages)


def _word(value: Any) -> str:
    return os.fsdecode(value) if isinstance(value, (bytes, os.PathLike)) else str(value)


def _option(name: str, value: Any) -> list[str]:
    if isinstance(value, (bool, np.bool_)):
        return [name] if value else []
    if value is None:
        return []
    if isinstance(value, (str, bytes, os.PathLike)) or not isinstance(value, Iterable):
        return [name, _word(value)]
    values = [_word(one) for one in value]
    return [name, *values] if values else []


def read_exterior(path: Path) -> ExteriorResult:
    """Reads a photo's <photo>.exterior.json."""
    return _native.read_exterior(path)


def read_interior(path: Path) -> InteriorResult:
    """Reads a photo's <photo>.interior.json."""
    return _native.read_interior(path)


class Poses(NamedTuple):
    """A table of orientations (`orientation.csv`)."""

    photos: list[str]
    positions: np.ndarray  # (n, 3) metres
    angles: np.ndarray  # (n, 3) omega, phi, kappa in radians
    sigmas: np.ndarray  # (n, 6) of both
    crs: Optional[str]  # WKT


def read_poses(path: Path) -> Poses:
    """Reads an OPK CSV with the .prj beside it."""
    table = _native.read_poses(path)
    return Poses(table["photos"], table["poses"][:, :3], table["poses"][:, 3:], table["sigmas"],
                 table["crs"])


class Block:
    """The results in a folder of `orient block` or `orient exterior`.

    `interior` is the folder of film photos' interior orientations, if it is a different one.
    """

    def __init__(self, folder: Path, interior: Optional[Path] = None):
        self.folder = pathlib.Path(os.fsdecode(folder))
        self.interior_folder = (self.folder if interior is None
                                else pathlib.Path(os.fsdecode(interior)))
        paths = sorted(self.folder.glob("*.exterior.json"))
        if not paths:
            raise InputError(f"{self.folder} holds no *.exterior.json; is it the output folder of "
                             "orient block or orient exterior?")
        self.photos: tuple[ExteriorResult, ...] = tuple(read_exterior(path) for path in paths)
        self._by_name = {photo.photo: photo for photo in self.photos}

    def __repr__(self) -> str:
        return f"<Block {self.folder}: {len(self.photos)} photos>"

    def __len__(self) -> int:
        return len(self.photos)

    def __iter__(self) -> Iterator[ExteriorResult]:
        return iter(self.photos)

    def __contains__(self, name: object) -> bool:
        return name in self._by_name

    def __getitem__(self, name: str) -> ExteriorResult:
        return self._by_name[name]

    @property
    def names(self) -> list[str]:
        return [photo.photo for photo in self.photos]

    @property
    def statuses(self) -> list[str]:
        """ok, weak or failed."""
        return [photo.status for photo in self.photos]

    @property
    def positions(self) -> np.ndarray:
        """Projection centres, (n, 3) metres."""
        return np.array([photo.pose[:3] for photo in self.photos])

    @property
    def angles(self) -> np.ndarray:
        """Omega, phi, kappa, (n, 3) radians."""
        return np.array([photo.pose[3:] for photo in self.photos])

    @property
    def covariances(self) -> np.ndarray:
        """(n, 6, 6): metres and radians."""
        return np.array([photo.covariance for photo in self.photos])

    @property
    def crs(self) -> Optional[str]:
        """WKT, from the .prj beside the table of poses; None if there is none."""
        table = self.folder / "orientation.csv"
        return read_poses(table).crs if table.exists() else None

    @property
    def adjustment(self) -> Optional[dict]:
        """block.json, if the block was adjusted: ties, checks, variance components."""
        path = self.folder / "block.json"
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None

    def interior(self, name: str) -> InteriorResult:
        """The interior orientation of a film photo."""
        return read_interior(self.interior_folder / f"{name}.interior.json")

    def geometry(self, name: str) -> PhotoGeometry:
        """The transformation between a photo's scan and the ground."""
        return PhotoGeometry.of_result(self.folder, name, self.interior_folder)

    def geodataframe(self) -> Any:
        """The photos as a GeoDataFrame: footprints, pose, status and reasons; needs geopandas."""
        import geopandas
        import shapely.geometry
        names = ("x", "y", "z", "omega", "phi", "kappa")
        rows = [{"photo": photo.photo, "status": photo.status,
                 "reasons": "; ".join(map(str, photo.findings)), **dict(zip(names, photo.pose))}
                for photo in self.photos]
        outlines = [shapely.geometry.Polygon(photo.footprint_m) if len(photo.footprint_m) else None
                    for photo in self.photos]
        return geopandas.GeoDataFrame(rows, geometry=outlines, crs=self.crs)
