// The further sources that show a patch: which one sees it best, and where each of them shows it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/raster/raster.h"
#include "patchdb/harvest/place.h"
#include "patchdb/harvest/source_view.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

// Where a raster holds data, on a grid of about 256 cells per side: an orthophoto's frame has black
// corners that its georeference knows nothing of.
class Coverage {
 public:
  explicit Coverage(const Raster& raster);
  // The pixel's cell and all of its neighbours hold data.
  bool Covers(const Eigen::Vector2d& pixel) const;

 private:
  ImageWindow overview_;
};

// A source besides the one being harvested; nothing here is owned.
struct FurtherSource {
  const Raster* raster = nullptr;
  const SourceView* view = nullptr;
  const Coverage* coverage = nullptr;  // absent: it holds data wherever the view says so
  int number = 0;                      // the caller's, to tell sources apart
};

// How well a source shows a ground point, m: its GSD there, times 1 + nadir distance / height.
// Smaller is better. Empty if it does not show the square of `chip_px` pixels
// around the point.
std::optional<double> ViewingPenalty(const FurtherSource& source, const Eigen::Vector3d& ground_m,
                                     int chip_px);

struct MatchOptions {
  int template_px = 41;         // odd; the middle of the chip, whose parallax is its ground point's
  double radius_px = 6;         // of the search, chip pixels
  double min_score = 0.7;       // of the template, and of its core
  double min_score_gap = 0.05;  // to the second-best place
};

// Where another source shows what the patch's chip shows in its middle: the source is rectified
// with the patch's heights and searched around the same ground point by correlation and least
// squares. Empty where it is not found there, or not clearly.
std::optional<Sighting> FindIn(const FurtherSource& source, const Patch& patch,
                               const MatchOptions& options);

}  // namespace orient::patchdb
