// What people measured and decided about photos: an input like any other, in files of its own that
// no run ever writes. docs/measurements.md describes the folder.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/transform2d.h"

namespace orient {

// Who measured or decided it and when, as they wrote it; both may be empty.
struct Attribution {
  std::string by, when;
};

// A fiducial mark clicked on a scan.
struct MarkMeasurement {
  std::string photo, mark;  // the mark's id in the camera file
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 1;  // of each coordinate
  bool exact = false;   // the click itself counts; nothing is measured around it
  Attribution attribution;
};

// A ground point seen in a photo: on the scan, or in the photo system where another program has
// measured it there.
struct ImagePointMeasurement {
  std::string photo, point;
  std::optional<Eigen::Vector2d> pixel, photo_mm;  // one of them
  double sigma = 1;                                // of each coordinate, pixels or mm
  Attribution attribution = {};
};

enum class PointRole { kControl, kCheck };

// A point with known coordinates: surveyed, or read from a map.
struct GroundPoint {
  std::string name;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();
  PointRole role = PointRole::kControl;
  Attribution attribution = {};
};

enum class DecisionKind {
  kAccept,
  kReject,
  kOrientation,
  kPolarity,
  kCamera,
  kPixelSize,
  kPosition
};
std::string_view Name(DecisionKind kind);  // "accept", "reject", "orientation", ... "position"
std::optional<DecisionKind> DecisionKindFromName(const std::string& name);

struct Decision {
  std::string photo;
  DecisionKind kind = DecisionKind::kAccept;
  // "r90", "negative", a camera's name, micrometres, "X Y SIGMA"; empty: accept and reject.
  std::string value;
  std::string reason;
  Attribution attribution;
};

// Roughly where a photo was taken, in the block's CRS.
struct DecidedPosition {
  Eigen::Vector2d ground_m = Eigen::Vector2d::Zero();
  double sigma_m = 1;  // of each coordinate
};

struct Measurements {
  std::string folder;  // where they were read; empty: there are none
  std::vector<MarkMeasurement> marks;
  std::vector<ImagePointMeasurement> image_points;
  std::vector<GroundPoint> points;
  std::vector<Decision> decisions;

  std::vector<MarkMeasurement> MarksOf(const std::string& photo) const;
  std::vector<ImagePointMeasurement> ImagePointsOf(const std::string& photo) const;
  const GroundPoint* Point(const std::string& name) const;
  // Null where nothing was decided.
  const Decision* DecisionOn(const std::string& photo, DecisionKind kind) const;
  // What was decided of how the photo lies on its scan.
  std::optional<ScanOrientation> OrientationOf(const std::string& photo) const;
  std::optional<Polarity> PolarityOf(const std::string& photo) const;
  std::optional<double> PixelSizeOf_um(const std::string& photo) const;
  std::optional<DecidedPosition> PositionOf(const std::string& photo) const;
};

inline constexpr const char* kMarksFile = "marks.csv";
inline constexpr const char* kImagePointsFile = "image_points.csv";
inline constexpr const char* kPointsFile = "points.csv";
inline constexpr const char* kDecisionsFile = "decisions.csv";

// The files of a folder; those that are absent say nothing. Throws InputError naming file, line,
// column and value: wrong columns or values, one thing said twice, a folder without any of them.
Measurements ReadMeasurements(const std::string& folder);

// One of the four files; a file of nothing has its header. Throws InputError where it cannot be
// written.
void WriteMarks(const std::string& folder, const std::vector<MarkMeasurement>& marks);
// All points in pixels, or all in the photo system: throws std::invalid_argument for both.
void WriteImagePoints(const std::string& folder, const std::vector<ImagePointMeasurement>& points);
void WritePoints(const std::string& folder, const std::vector<GroundPoint>& points);
void WriteDecisions(const std::string& folder, const std::vector<Decision>& decisions);

// All that is said of a photo's marks, and of how it lies: a text that changes when it does; empty
// where nothing is. Who said it and when is no part of it, nor where the photo was taken.
std::string TextOfMarks(const Measurements& measurements, const std::string& photo);
// The same of its ground points with their coordinates.
std::string TextOfPoints(const Measurements& measurements, const std::string& photo);

// What is wrong with `value` for a decision of this kind; empty if it is valid.
std::string DecisionProblem(DecisionKind kind, const std::string& value);

// "J. Smith, 2024-05-01: reason": what findings name.
std::string TextOf(const Decision& decision);

}  // namespace orient
