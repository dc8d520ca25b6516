// A drawing fitted to a mark as scans show it, so that nobody has to measure strokes by hand.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/files/mark_elements.h"
#include "core/raster/image.h"
#include "core/raster/raster.h"

namespace orient::interior {

// A mark on a scan, cut out around the place where a person saw it.
struct SeenMark {
  Image image;                                     // bright is bright on a positive
  Eigen::Vector2d near = Eigen::Vector2d::Zero();  // the person's place, pixels of `image`
  Eigen::Matrix2d pixel_from_mm = Eigen::Matrix2d::Identity();  // linear part: size and orientation
  double reach_px = 4;  // the mark's centre is looked for within this distance of `near`, per axis
};

// The largest extent from its centre of a mark that is fitted, mm.
inline constexpr double kLargestFittedRadius_mm = 3.8;

struct CutOptions {
  double radius_mm = 1.1 * kLargestFittedRadius_mm;  // of the surroundings
  double reach_px = 4;                               // SeenMark's, in pixels of the scan
  double reduction = 1;                              // pixels of the scan per pixel cut out
  bool negative = false;                             // the scan
};

// The surroundings of a mark that was seen at `pixel`. `pixel_from_mm`: of the scan. `window`,
// where it is given, becomes the place and scale of the image on the scan, without pixels of its
// own.
SeenMark CutMark(const Raster& scan, const Eigen::Vector2d& pixel,
                 const Eigen::Matrix2d& pixel_from_mm, const CutOptions& options = {},
                 ImageWindow* window = nullptr);

struct FittedDrawing {
  // One to three around the mark's centre: cross, circle, dot, wedge, checker. Lengths are rounded
  // to 5 micrometres, crosses that are nearly upright or diagonal are made so.
  std::vector<MarkElement> elements;
  std::vector<Eigen::Vector2d> centre;  // of each mark seen, pixels of its image
  std::vector<double> correlation;      // of drawing and scan at each of them, -1 to 1

  double MeanCorrelation() const;
};

// The drawing that explains marks of one look. Elements are added as long as the pixels say so
// (Bayesian information criterion), in windows of 0.6 to 4 mm around the centre; the largest window
// counts that the drawing explains about as well as the best one, for smaller ones show but a part
// of the mark. Blur and contrast are no part of a drawing. Empty where `marks` is, or no element
// resembles them.
std::optional<FittedDrawing> FitDrawing(const std::vector<SeenMark>& marks);

// Where marks of a known drawing are, and how well it explains them with their surroundings, as far
// as a mark of `radius_mm` would reach if that is more than the drawing's own: drawings can be
// compared over the same surroundings only. `elements` are not changed.
FittedDrawing LocateDrawing(const std::vector<MarkElement>& elements,
                            const std::vector<SeenMark>& marks, double radius_mm = 0);

// From the mark's centre to its farthest point, mm.
double RadiusOf(const std::vector<MarkElement>& elements);

}  // namespace orient::interior
