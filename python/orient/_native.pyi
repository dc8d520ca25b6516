import os
from typing import Any, Callable, Optional, Union

import numpy as np

Path = Union[str, bytes, os.PathLike]

version: str

class InputError(ValueError): ...
class UsageError(ValueError): ...
class MachineError(OSError): ...

class Finding:
    """Why a result is what it is (docs/findings.md)."""
    @property
    def code(self) -> str: ...
    @property
    def at_best(self) -> str: ...
    @property
    def value(self) -> Optional[float]: ...
    @property
    def limit(self) -> Optional[float]: ...
    @property
    def where(self) -> str: ...

class InteriorResult:
    @property
    def photo(self) -> str: ...
    @property
    def status(self) -> str: ...
    @property
    def findings(self) -> list[Finding]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def pixel_size_um(self) -> Optional[float]: ...
    @property
    def polarity(self) -> Optional[str]: ...
    @property
    def scan_orientation(self) -> Optional[str]: ...
    @property
    def possible_orientations(self) -> list[str]: ...
    @property
    def photo_from_pixel(self) -> Optional[np.ndarray]:
        """(2, 3): mm from (col, row, 1)."""
    @property
    def sigma0_um(self) -> Optional[float]: ...
    @property
    def marks(self) -> dict[str, Any]:
        """id, state, pixel (n, 2), sigma_px, residual_um, score."""
    @property
    def cameras(self) -> list[str]: ...

class ExteriorResult:
    @property
    def photo(self) -> str: ...
    @property
    def status(self) -> str: ...
    @property
    def findings(self) -> list[Finding]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def pose(self) -> np.ndarray:
        """(6,): x, y, z in metres, omega, phi, kappa in radians."""
    @property
    def covariance(self) -> np.ndarray:
        """(6, 6), of the pose."""
    @property
    def sigma0_px(self) -> Optional[float]: ...
    @property
    def projection_sigma(self) -> Optional[tuple[float, float]]:
        """Largest one-sigma uncertainty of a coordinate in the frame: pixels, metres."""
    @property
    def target_m(self) -> Optional[float]: ...
    @property
    def scan_orientation(self) -> Optional[str]: ...
    @property
    def footprint_m(self) -> np.ndarray:
        """(n, 3), a closed ring."""
    @property
    def patches(self) -> dict[str, Any]:
        """id, state, ground_m (n, 3), predicted_px (n, 2), pixel, sigma_px, residual_px, ncc."""

class Surface:
    def __init__(self, path: Path, crs: str) -> None: ...
    def heights(self, places: np.ndarray) -> np.ndarray:
        """(n,) at (n, 2)."""

class PhotoGeometry:
    @staticmethod
    def of_result(folder: Path, photo: str, interior: Path = "") -> PhotoGeometry: ...
    @staticmethod
    def of_pose(camera: Path, pose: np.ndarray) -> PhotoGeometry:
        """Of a digital camera's photo: its file or a name of the camera library; (6,)."""
    @property
    def pose(self) -> np.ndarray: ...
    @property
    def principal_distance_mm(self) -> float: ...
    def pixels(self, ground: np.ndarray) -> np.ndarray:
        """(n, 2) in the scan; NaN outside the camera's frame and behind the camera."""
    def photo_mm(self, pixels: np.ndarray) -> np.ndarray:
        """(n, 2) in the photo system."""
    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """(n, 3): unit directions from the projection centre."""
    def ground(self, pixels: np.ndarray, surface: Surface) -> np.ndarray:
        """(n, 3) where the rays meet the surface."""

def run(arguments: list[str], progress: Optional[Callable[[str, int, int], Any]] = None
        ) -> tuple[int, str, str]: ...
def read_interior(path: Path) -> InteriorResult: ...
def read_exterior(path: Path) -> ExteriorResult: ...
def read_poses(path: Path) -> dict[str, Any]: ...
