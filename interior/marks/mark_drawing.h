// A fiducial mark as the scanner sees it: its drawing rendered at any pixel size, turned and
// mirrored as the film lies, through the scanner's blur.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/files/camera_file.h"
#include "core/raster/image.h"
#include "interior/marks/background.h"

namespace orient::interior {

// A drawing together with the picture it may refer to (the library opens no files).
struct MarkShape {
  MarkDrawing drawing;
  std::optional<Image> picture;  // must be there where drawing.image is
};
using MarkShapes = std::map<std::string, MarkShape>;

// Half the largest extent, mm: no part of the mark lies farther from its centre.
double MarkRadius(const MarkShape& shape);

// The thinnest and the widest stroke, mm (0.1 for a picture, whose strokes are unknown).
double ThinnestStroke(const MarkShape& shape);
double WidestStroke(const MarkShape& shape);

// Signed distance in mm from a point (mm, mark system) to the nearest element, whatever its
// brightness and as drawn; negative inside. Drawings without elements have none: infinity.
double StrokeDistance(const MarkDrawing& drawing, const Eigen::Vector2d& point_mm);

struct RenderOptions {
  double blur_sigma_px = 0.7;  // of the scanner beyond the area average of a pixel
  double margin_mm = 0.35;     // around the strokes; farther pixels are not part of the template
  int supersampling = 6;       // per axis
  double background_sigma_px = 0;  // RemoveBackground before cutting out; 0: not
  // Of the mark's centre from a pixel's centre.
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();
  // Outlines are not sampled but cross each sample's square smoothly: they lie where they are to
  // 0.003 px in all directions, for strokes at least two samples wide.
  bool smooth_outlines = false;
  bool whole_square = false;  // farther pixels are kept
};

struct MarkTemplate {
  Image values;                                      // brightness as drawn; NaN not part of it
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // the mark's centre, pixels of `values`
};

// `pixel_from_mm` is the linear part of pixel from photo mm: size, rotation and mirroring at once.
// Throws std::invalid_argument where it is singular, or the drawing has neither elements nor a
// picture.
MarkTemplate RenderMark(const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm,
                        const RenderOptions& options = {});

// Which pixels of a square of 2 half + 1 pixels around the mark's centre lie at most `margin_mm`
// from a stroke, row by row.
std::vector<bool> NearStrokes(const MarkDrawing& drawing, const Eigen::Matrix2d& mm_from_pixel,
                              int half, double margin_mm);

// True when the mark looks the same after `turn` (an orthogonal matrix, mark system).
bool LooksSame(const MarkShape& shape, const Eigen::Matrix2d& turn);

// True when `turned` is what `shape` looks like after `turn` (notches that point outwards differ
// from side to side, and become one another when the film is turned).
bool LooksSame(const MarkShape& shape, const MarkShape& turned, const Eigen::Matrix2d& turn);

// True when nothing tells the mark from what it becomes under `turn`, neither its brightness nor
// its place; false for pictures.
bool IsSymmetric(const MarkShape& shape, const Eigen::Matrix2d& turn);

// LooksSame for the marks of one camera by name; every answer is found once.
class MarkLikeness {
 public:
  explicit MarkLikeness(const MarkShapes& shapes) : shapes_(shapes) {}

  bool Same(const std::string& mark, const std::string& turned, const Eigen::Matrix2d& turn);

 private:
  using Key = std::tuple<std::string, std::string, std::array<double, 4>>;

  const MarkShapes& shapes_;
  std::map<Key, bool> known_;
  std::map<std::pair<std::string, double>, MarkTemplate> upright_;  // by mark and radius shown
};

}  // namespace orient::interior
