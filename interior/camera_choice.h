// Which of the known cameras a scan is from: each is fitted to the scan, and one is chosen only if
// the best interpretation is certain by itself and no camera with another geometry comes close.
//
// Cameras whose marks agree (an RC10 with 15 and with 21 cm lens) give one transform: that is no
// ambiguity. An unknown camera is not accepted as the best of the wrong ones: the pixel size is
// tested as well, where the scan or the user states it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "interior/interior.h"

namespace orient::interior {

// Cameras with more marks (a reseau) are not tried; they must be named (one would cost as much as
// all the other cameras together).
inline constexpr size_t kMostMarksOfUnknownCamera = 12;

struct KnownCamera {
  std::string name;
  const CameraFile* file = nullptr;
  const MarkShapes* shapes = nullptr;
};

// One camera's interpretation of the scan.
struct CameraReading {
  size_t camera = 0;  // index of the known camera
  InteriorResult result;
  double nats = 0;  // log odds of the marks used against clutter
};

struct CameraChoice {
  // The chosen camera's result, with the names of all cameras that fit as well in `cameras`;
  // failed, with the best candidates in its messages, where no camera can be chosen.
  InteriorResult result;
  std::optional<size_t> camera;  // index of the known camera; empty: unknown
};

// The decision alone. `pixel_size_um`: what the user or the resolution tag says; empty: unknown.
CameraChoice ChooseCamera(const std::vector<KnownCamera>& cameras,
                          const std::vector<CameraReading>& readings,
                          std::optional<double> pixel_size_um);

// Reads the scan with every known film camera of at most twelve marks (cameras of like marks only
// once) and chooses. Cameras whose marks do not fit on the scan at the stated pixel size, or whose
// film would be a small part of it, are tried only where none of the others fits; larger ones also
// where what fits has marks of the same shape. Throws InputError as OrientInterior.
CameraChoice OrientWithUnknownCamera(const Raster& scan, const std::vector<KnownCamera>& cameras,
                                     const InteriorOptions& options = {});

}  // namespace orient::interior
