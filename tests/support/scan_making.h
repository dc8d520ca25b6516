// Scans with a known truth, and what may befall them: cut, turned, inverted, fogged, put beside a
// neighbouring frame or on a bed, written with any resolution tag, as one bit, or only half of it.
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
  std::vector<TruePlace> marks;  // on the film, whether on the scan or not
  Polarity polarity = Polarity::kPositive;
};

// What lies at p of `scan` lies at map * p of the result; `fill` is what the scan does not show.
TrueScan Moved(const TrueScan& scan, const Affine2d& map, int width, int height, float fill);

struct Margins {
  int left = 0, top = 0, right = 0, bottom = 0;
};
// Cut off, px; a negative margin adds a bed of `fill`.
TrueScan Cut(const TrueScan& scan, const Margins& margins, float fill = 250);
TrueScan MirroredScan(const TrueScan& scan);  // left to right
TrueScan UpsideDown(const TrueScan& scan);
// Counter-clockwise, on a bed that is as large as needed.
TrueScan TurnedScan(const TrueScan& scan, double degrees, float fill);
TrueScan NegativeScan(const TrueScan& scan);
TrueScan NoisyScan(const TrueScan& scan, double sigma, unsigned seed);
// Brightness falls to `at_corners` of itself, then `fog` is added.
TrueScan FoggedScan(const TrueScan& scan, double at_corners, float fog);
// Black or white, by a threshold, or by error diffusion (Floyd & Steinberg 1976).
TrueScan Bilevel(const TrueScan& scan, std::optional<float> threshold);
// `next` to the right of or below the scan, over its last `overlap` pixels; the truth is the
// first one's.
TrueScan Beside(const TrueScan& scan, const Image& next, int overlap);
TrueScan Above(const TrueScan& scan, const Image& next, int overlap);

struct TiffOptions {
  Eigen::Vector2d dpi = Eigen::Vector2d::Zero();  // along columns' and rows' axes; 0: no tag
  bool one_bit = false;
};
// Uncompressed, in strips of 64 rows. Throws std::runtime_error where it cannot be written.
void WriteTiffScan(const std::string& path, const Image& scan, const TiffOptions& options);

}  // namespace orient
