#include "tools/simulate/truth_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "core/geometry/collinearity.h"
#include "tools/simulate/geotiff.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr double kMaskCell_m = 2;

Json ToJson(const Affine2d& a) {
  return Json::array(
      {Json::array({a.A(0, 0), a.A(0, 1), a.t.x()}), Json::array({a.A(1, 0), a.A(1, 1), a.t.y()})});
}

Json ToJson(const Pose& pose) {
  return {{"x", pose.position_m.x()},           {"y", pose.position_m.y()},
          {"z", pose.position_m.z()},           {"omega", DegFromRad(pose.opk_rad[0])},
          {"phi", DegFromRad(pose.opk_rad[1])}, {"kappa", DegFromRad(pose.opk_rad[2])}};
}

const char* Name(MarkCondition condition) {
  switch (condition) {
    case MarkCondition::kMissing:
      return "missing";
    case MarkCondition::kDirty:
      return "dirty";
    case MarkCondition::kScratched:
      return "scratched";
    case MarkCondition::kDusty:
      return "dusty";
    case MarkCondition::kArmLost:
      return "arm lost";
    case MarkCondition::kClean:
      break;
  }
  return "clean";
}

Json MarksJson(const SimulatedCamera& camera, const PhotoPlan& plan) {
  Json marks = Json::array();
  for (size_t i = 0; i < camera.file.fiducials.size(); ++i) {
    const Fiducial& fiducial = camera.file.fiducials[i];
    const Vector2d pixel = plan.scan.PixelFromPhoto(fiducial.position_mm);
    marks.push_back({{"id", fiducial.id},
                     {"condition", Name(plan.marks[i])},
                     {"pixel", {pixel.x(), pixel.y()}}});
  }
  return marks;
}

// Check points of this photo: where the ground point really lies in the scan.
Json CheckJson(const SimulatedCamera& camera, const PhotoPlan& plan,
               const std::vector<Vector3d>& points) {
  Json seen = Json::array();
  for (size_t i = 0; i < points.size(); ++i) {
    const auto photo = PhotoFromGround(camera.Seeing(), plan.photo.pose, points[i]);
    if (!photo || !camera.file.camera.InFrame(*photo)) continue;
    const Vector2d pixel = plan.scan.PixelFromPhoto(*photo);
    seen.push_back({{"point", i}, {"pixel", {pixel.x(), pixel.y()}}});
  }
  return seen;
}

Json PhotoJson(const SimulatedCamera& camera, const PhotoPlan& plan,
               const std::vector<Vector3d>& points) {
  const ScanSetup& setup = plan.scan.Setup();
  return {{"photo", plan.photo.name},
          {"pose", ToJson(plan.photo.pose)},
          {"scan",
           {{"width", setup.width},
            {"height", setup.height},
            {"pixel_size_um", setup.pixel_size_mm * 1e3},
            {"polarity", orient::Name(plan.polarity)},
            {"orientation", orient::Name(setup.orientation)},
            {"rotation_deg", DegFromRad(setup.rotation_rad)}}},
          {"photo_from_pixel", ToJson(plan.scan.BestAffine())},
          {"bend_rms_um", plan.scan.BendRms() * 1e3},
          {"marks", MarksJson(camera, plan)},
          {"check", CheckJson(camera, plan, points)}};
}

bool NearObject(const Scene& scene, const Vector3d& point) {
  const Eigen::Vector2f p(static_cast<float>(point.x() - scene.extent.min_x),
                          static_cast<float>(point.y() - scene.extent.min_y));
  for (const Building& building : scene.buildings)
    if ((building.centre - p).norm() < 12 + building.half_length) return true;
  for (const Tree& tree : scene.trees)
    if ((tree.centre - p).norm() < tree.height + tree.radius) return true;
  return false;
}

// Where an object of this size may be visible at either date: the object itself, leaning in a photo
// as much as at a wide angle, and its shadow. Positions: the scene's.
class StandingMask {
 public:
  StandingMask(int width, int height)
      : width_(width),
        height_(height),
        mask_(static_cast<size_t>(width) * static_cast<size_t>(height), 0) {}

  void Add(const Eigen::Vector2f& centre, double radius_m, double height_m) {
    constexpr double kLean = 0.7;
    const Vector2d foot = centre.cast<double>();
    Mark(foot, foot, radius_m + kLean * height_m);
    for (const Epoch epoch : {Epoch::kOld, Epoch::kNew}) {
      const Vector3d sun = SunDirection(epoch);
      Mark(foot, foot - sun.head<2>() * (height_m / sun.z()), radius_m);
    }
  }
  int Width() const { return width_; }
  int Height() const { return height_; }
  const std::vector<std::uint16_t>& Cells() const { return mask_; }

 private:
  // Marks what lies within `reach_m` of the line from `a` to `b`.
  void Mark(const Vector2d& a, const Vector2d& b, double reach_m) {
    const double reach = reach_m + kMaskCell_m;
    const auto index = [](double x, int size) {
      return std::clamp(static_cast<int>(x / kMaskCell_m), 0, size - 1);
    };
    for (int j = index(std::min(a.y(), b.y()) - reach, height_);
         j <= index(std::max(a.y(), b.y()) + reach, height_); ++j)
      for (int i = index(std::min(a.x(), b.x()) - reach, width_);
           i <= index(std::max(a.x(), b.x()) + reach, width_); ++i) {
        const Vector2d cell = kMaskCell_m * Vector2d(i + 0.5, j + 0.5);
        const double length2 = std::max((b - a).squaredNorm(), 1e-6);
        const double along = std::clamp((cell - a).dot(b - a) / length2, 0.0, 1.0);
        if ((cell - a - along * (b - a)).norm() < reach)
          mask_[static_cast<size_t>(height_ - 1 - j) * static_cast<size_t>(width_) +
                static_cast<size_t>(i)] = 1;
      }
  }

  int width_, height_;
  std::vector<std::uint16_t> mask_;  // row 0 in the north
};

}  // namespace

std::vector<Vector3d> CheckPoints(const BlockTruth& truth) {
  constexpr int kAcross = 24;
  std::vector<PlannedPhoto> photos;
  for (const PhotoPlan& plan : truth.fresh) photos.push_back(plan.photo);
  const Bounds area =
      FootprintBounds(truth.fresh_camera.file.camera, photos, truth.terrain.MinHeight());
  const double step = std::max(area.max_x - area.min_x, area.max_y - area.min_y) / kAcross;
  std::vector<Vector3d> points;
  for (double y = area.min_y + 0.5 * step; y < area.max_y; y += step)
    for (double x = area.min_x + 0.5 * step; x < area.max_x; x += step) {
      const Vector3d point(x, y, truth.terrain.HeightAt(x, y));
      if (!NearObject(truth.scene, point)) points.push_back(point);
    }
  return points;
}

void WriteTruth(const std::string& path, const BlockTruth& truth) {
  const std::vector<Vector3d> points = CheckPoints(truth);
  Json json;
  json["seed"] = truth.options.seed;
  json["gsd_m"] = truth.options.gsd_m;
  json["old_gsd_m"] = truth.options.gsd_m * truth.options.old_gsd_ratio;
  json["change_mask"] = "change.tif";
  json["check_points"] = Json::array();
  for (const Vector3d& point : points)
    json["check_points"].push_back({point.x(), point.y(), point.z()});
  for (const PhotoPlan& plan : truth.fresh)
    json["photos"].push_back(PhotoJson(truth.fresh_camera, plan, points));
  for (const PhotoPlan& plan : truth.old)
    json["old_photos"].push_back(PhotoJson(truth.old_camera, plan, points));
  WriteFileAtomically(path, json.dump(1) + "\n");
}

void WriteChangeMask(const std::string& path, const BlockTruth& truth, const Crs& crs) {
  const Scene& scene = truth.scene;
  const auto width = static_cast<int>((scene.extent.max_x - scene.extent.min_x) / kMaskCell_m);
  const auto height = static_cast<int>((scene.extent.max_y - scene.extent.min_y) / kMaskCell_m);
  std::vector<std::uint16_t> mask;
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      const auto x = static_cast<float>((col + 0.5) * kMaskCell_m);
      const auto y =
          static_cast<float>(scene.extent.max_y - scene.extent.min_y - (row + 0.5) * kMaskCell_m);
      const LandAt at = scene.land.At(x, y);
      const bool road = std::abs(at.road_m) < 4 || std::abs(at.track_m) < 2;
      const Change change = scene.parcel_change[static_cast<size_t>(at.parcel)];
      mask.push_back(change != Change::kNone && !road ? 1 : 0);
    }
  for (const Building& building : scene.buildings) {
    if (building.at_old == building.at_new) continue;
    const int reach = static_cast<int>(std::ceil(building.half_length / kMaskCell_m));
    const int col = static_cast<int>(building.centre.x() / kMaskCell_m);
    const int row = height - 1 - static_cast<int>(building.centre.y() / kMaskCell_m);
    for (int j = std::max(0, row - reach); j <= std::min(height - 1, row + reach); ++j)
      for (int i = std::max(0, col - reach); i <= std::min(width - 1, col + reach); ++i)
        mask[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)] = 2;
  }
  WriteGreyTiff(path, width, height, mask, 8, std::nullopt,
                GeoReference{scene.extent.min_x, scene.extent.max_y, kMaskCell_m, crs});
}

void WriteStandingMask(const std::string& path, const BlockTruth& truth, const Crs& crs) {
  const Scene& scene = truth.scene;
  StandingMask mask(static_cast<int>((scene.extent.max_x - scene.extent.min_x) / kMaskCell_m),
                    static_cast<int>((scene.extent.max_y - scene.extent.min_y) / kMaskCell_m));
  for (const Building& building : scene.buildings)
    mask.Add(building.centre,
             static_cast<double>(std::hypot(building.half_length, building.half_width)),
             static_cast<double>(building.ridge));
  for (const Tree& tree : scene.trees)
    mask.Add(tree.centre, static_cast<double>(tree.radius), static_cast<double>(tree.height));
  WriteGreyTiff(path, mask.Width(), mask.Height(), mask.Cells(), 8, std::nullopt,
                GeoReference{scene.extent.min_x, scene.extent.max_y, kMaskCell_m, crs});
}

}  // namespace orient::simulation
