// Scans with known truth, and what may happen to them: cropped, rotated, inverted, fogged, joined
// to a neighbouring frame, placed on a scanner bed, written with any resolution tag or with one
// bit.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/transform2d.h"
#include "core/raster/image.h"

namespace orient {

struct TruePlace {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 0;
};

struct TrueScan {
  Image image;  // 0..255
  Affine2d pixel_from_photo;
  std::vector<TruePlace> marks;  // of the film, whether within the scan or not
  Polarity polarity = Polarity::kPositive;
};

// Position p of `scan` becomes map * p in the result; `fill` is used where the scan shows nothing.
TrueScan Moved(const TrueScan& scan, const Affine2d& map, int width, int height, float fill);

struct Margins {
  int left = 0, top = 0, right = 0, bottom = 0;
};
// Crops by margins in px; a negative margin adds a scanner bed of `fill`.
TrueScan Cut(const TrueScan& scan, const Margins& margins, float fill = 250);
TrueScan MirroredScan(const TrueScan& scan);  // left to right
TrueScan UpsideDown(const TrueScan& scan);
// Rotates counter-clockwise, on a scanner bed that is as large as needed.
TrueScan TurnedScan(const TrueScan& scan, double degrees, float fill);
TrueScan NegativeScan(const TrueScan& scan);
TrueScan NoisyScan(const TrueScan& scan, double sigma, unsigned seed);
// Brightness falls off to the share `at_corners` at the corners, then `fog` is added.
TrueScan FoggedScan(const TrueScan& scan, double at_corners, float fog);
// Black and white by a threshold or, without one, by error diffusion (Floyd & Steinberg 1976).
TrueScan Bilevel(const TrueScan& scan, std::optional<float> threshold);
// `next` to the right of or below the scan, covering its last `overlap` pixels; the truth is that
// of the first one.
TrueScan Beside(const TrueScan& scan, const Image& next, int overlap);
TrueScan Above(const TrueScan& scan, const Image& next, int overlap);

struct TiffOptions {
  Eigen::Vector2d dpi = Eigen::Vector2d::Zero();  // along the column and row axes; 0: no tag
  bool one_bit = false;
};
// Uncompressed, in strips of 64 rows. Throws std::runtime_error if the file cannot be written.
void WriteTiffScan(const std::string& path, const Image& scan, const TiffOptions& options);

}  // namespace orient
