// Camera files (TOML): geometry, fiducial marks and the drawings of the marks.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/files/mark_elements.h"
#include "core/geometry/camera.h"

namespace orient {

enum class MarkBackground { kDark, kImage };

// A template image for marks that no drawing describes.
struct MarkImage {
  std::string path;  // absolute, or relative to the working directory
  double pixel_size_mm = 0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
};

struct MarkDrawing {
  std::vector<MarkElement> elements;  // painted in this order
  MarkBackground background = MarkBackground::kDark;
  std::optional<MarkImage> image;
};

enum class SymbolKind { kLines, kDots };

// An identification symbol: a row of `count` bars or dots beside the mark, within 6 mm of it.
struct MarkSymbol {
  SymbolKind kind = SymbolKind::kLines;
  int count = 0;
  std::optional<Eigen::Vector2d> at_mm;    // first element relative to the mark
  std::optional<Eigen::Vector2d> step_mm;  // to the next one
};

struct Fiducial {
  std::string id;
  Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
  std::string mark;  // key into CameraFile::marks
  std::optional<MarkSymbol> symbol;
  // Of the position, where it was estimated.
  std::optional<Eigen::Vector2d> sigma_mm = std::nullopt;
};

enum class FrameSide { kLeft, kRight, kBottom, kTop };  // as the positive is seen

// What a part of the film shows on a positive: writing on dark film (clock, level, counter, name
// plate), unexposed film where the picture would be, or exposed film where the rebate would be.
enum class BorderSign { kText, kDark, kBright };

// A rectangle of the photo system in which the frame's border is unlike its mirror images, so that
// it tells the scan orientation.
struct BorderFeature {
  BorderSign shows = BorderSign::kText;
  Eigen::Vector2d from_mm = Eigen::Vector2d::Zero();  // least x and y
  Eigen::Vector2d to_mm = Eigen::Vector2d::Zero();    // largest x and y
};

struct CameraFile {
  Camera camera;
  std::vector<Fiducial> fiducials;
  std::map<std::string, MarkDrawing> marks;
  std::optional<FrameSide> data_strip;  // the only side of the frame with writing beside it
  std::vector<BorderFeature> border;
};

// Why the principal distance cannot be that of the camera's frame; empty if it can.
std::string PrincipalDistanceProblem(const Camera& camera);

// Throws InputError naming file, key and remedy: unknown keys (with the nearest known one), wrong
// types, impossible values, a fiducial whose mark is not drawn.
CameraFile ReadCameraFile(const std::string& path);
void WriteCameraFile(const std::string& path, const CameraFile& camera);
// What would be written, with pictures of marks named relative to `folder`.
std::string CameraFileText(const CameraFile& camera, const std::string& folder);
// An element as it stands there: "{ shape = "dot", diameter_mm = 0.2 }".
std::string ElementText(const MarkElement& element);

}  // namespace orient
