// Camera files with everything that one may have, as text.
#pragma once

#include <stdexcept>
#include <string>

#include "core/base/atomic_write.h"
#include "core/files/camera_file.h"
#include "tests/support/shared_data.h"

namespace orient {

// A camera file with everything that one may have.
inline const std::string kFilm = R"(name = "Wild RC10, 15 UAG 1234"
kind = "film"
principal_distance_mm = 153.29
principal_point_mm = [0.012, -0.004]
frame_mm = [212.0, 212.0]
frame_centre_mm = [0.1, 0.0]

[distortion]
model = "brown"
k = [1.2e-8, 0.0, 0.0]
p = [1e-7, 0.0]

[[fiducials]]
id = "1"
position_mm = [-106.007, 106.004]
mark = "corner"
symbol = { kind = "lines", count = 1 }
[[fiducials]]
id = "2"
position_mm = [106.0, 106.0]
mark = "corner"
symbol = { kind = "dots", count = 2, at_mm = [1.0, 2.0], step_mm = [0.5, 0.0] }
[[fiducials]]
id = "3"
position_mm = [106, -106]
mark = "corner"
[[fiducials]]
id = "4"
position_mm = [-106.0, -106.0]
mark = "corner"

[marks.corner]
elements = [
  { shape = "cross",  length_mm = 2.0, width_mm = 0.06, gap_mm = 0.3, angle_deg = 45 },
  { shape = "dot",    diameter_mm = 0.12 },
  { shape = "circle", diameter_mm = 1.6, width_mm = 0.08 },
]
background = "dark"
)";

inline const std::string kDigital = R"(name = "DMC"
kind = "digital"
principal_distance_mm = 120.0
principal_point_mm = [0.0, 0.0]
frame_mm = [92.16, 165.888]
image_px = [640, 1152]
)";

inline CameraFile ReadText(const std::string& text) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "camera.toml", text);
  return ReadCameraFile(folder / "camera.toml");
}

inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the example lacks " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace orient
