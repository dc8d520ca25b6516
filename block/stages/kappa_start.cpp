#include "block/stages/kappa_start.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>

#include "core/base/median.h"

namespace orient::block {
namespace {

// Tilt shifts a photo's image of the ground as a whole, by more than tilt and relief deform it.
constexpr double kWeightOfPlaces = 0.1;
// Photos of one flight have about one scale.
constexpr double kMostScale = 1.5;
constexpr int kUnknowns = 4;  // per photo: scale and rotation (a, b), error of its position

// Normal equations of all photos and points, in metres from the places' middle.
class PlaneAdjustment {
 public:
  PlaneAdjustment(const std::vector<LevelPhoto>& photos,
                  const std::map<std::string, Eigen::Vector2d>& ground_m)
      : photos_(photos), ground_m_(ground_m), joins_(photos.size(), 0) {
    std::map<std::string, int> rays;
    for (const LevelPhoto& photo : photos) {
      middle_m_ += photo.place_m / static_cast<double>(photos.size());
      for (const auto& [name, at_mm] : photo.seen_mm) ++rays[name];
    }
    auto unknowns = kUnknowns * static_cast<Eigen::Index>(photos.size());
    for (const auto& [name, count] : rays)
      if (count > 1 && !ground_m.contains(name)) {
        unknown_of_[name] = unknowns;
        unknowns += 2;
      }
    right_ = Eigen::VectorXd::Zero(unknowns);
    for (std::size_t i = 0; i < photos.size(); ++i) AddPhoto(i);
  }

  // Scale and rotation (a, b) of each photo; zero if they are not determined.
  std::vector<Eigen::Vector2d> Solve() {
    constexpr double kNothing = 1e-9;
    for (Eigen::Index i = 0; i < right_.size(); ++i) normal_.emplace_back(i, i, kNothing);
    Eigen::SparseMatrix<double> normal(right_.size(), right_.size());
    normal.setFromTriplets(normal_.begin(), normal_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
    std::vector<Eigen::Vector2d> similarities(photos_.size(), Eigen::Vector2d::Zero());
    if (solver.info() != Eigen::Success) return similarities;
    const Eigen::VectorXd solved = solver.solve(right_);
    for (std::size_t i = 0; i < photos_.size(); ++i)
      if (joins_[i] > 1)
        similarities[i] = solved.segment<2>(kUnknowns * static_cast<Eigen::Index>(i));
    return similarities;
  }

 private:
  using Row = std::vector<std::pair<Eigen::Index, double>>;

  void Add(const Row& row, double value, double weight) {
    for (const auto& [i, by_i] : row) {
      right_[i] += weight * by_i * value;
      for (const auto& [j, by_j] : row) normal_.emplace_back(i, j, weight * by_i * by_j);
    }
  }

  void AddPhoto(std::size_t i) {
    const auto first = kUnknowns * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d place = photos_[i].place_m - middle_m_;
    for (const int axis : {0, 1}) Add({{first + 2 + axis, 1}}, 0, kWeightOfPlaces);
    for (const auto& [name, at] : photos_[i].seen_mm) {
      const auto known = ground_m_.find(name);
      const auto unknown = unknown_of_.find(name);
      if (known == ground_m_.end() && unknown == unknown_of_.end()) continue;
      ++joins_[i];
      Row east = {{first, at.x()}, {first + 1, -at.y()}, {first + 2, 1}};
      Row north = {{first, at.y()}, {first + 1, at.x()}, {first + 3, 1}};
      Eigen::Vector2d value = -place;
      if (known != ground_m_.end()) {
        value += known->second - middle_m_;
      } else {
        east.emplace_back(unknown->second, -1);
        north.emplace_back(unknown->second + 1, -1);
      }
      Add(east, value.x(), 1);
      Add(north, value.y(), 1);
    }
  }

  const std::vector<LevelPhoto>& photos_;
  const std::map<std::string, Eigen::Vector2d>& ground_m_;
  std::vector<int> joins_;  // per photo: points that determine its similarity
  std::map<std::string, Eigen::Index> unknown_of_;
  Eigen::Vector2d middle_m_ = Eigen::Vector2d::Zero();
  std::vector<Eigen::Triplet<double>> normal_;
  Eigen::VectorXd right_;
};

}  // namespace

std::vector<std::optional<double>> KappasByPlaces(
    const std::vector<LevelPhoto>& photos, const std::map<std::string, Eigen::Vector2d>& ground_m) {
  if (photos.empty()) return {};
  const std::vector<Eigen::Vector2d> similarities = PlaneAdjustment(photos, ground_m).Solve();
  std::vector<double> scales;
  for (const Eigen::Vector2d& similarity : similarities)
    if (!similarity.isZero()) scales.push_back(similarity.norm());
  std::vector<std::optional<double>> kappas(photos.size());
  if (scales.empty()) return kappas;
  const double usual = Median(std::move(scales));
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const double scale = similarities[i].norm();
    if (scale * kMostScale >= usual && scale <= usual * kMostScale)
      kappas[i] = std::atan2(similarities[i].y(), similarities[i].x());
  }
  return kappas;
}

}  // namespace orient::block
