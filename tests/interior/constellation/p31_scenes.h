// Five marks of a P31 close-range camera among clutter (the Monte Carlo of Jiang, Zhang & Li's
// layout). Units are pixels where the paper's are.
#pragma once

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "core/geometry/transform2d.h"
#include "interior/constellation/assignment.h"

namespace orient::interior {

// Calibrated positions scaled to pixels of 25 um, y down (Table 3).
inline std::vector<Eigen::Vector2d> P31Marks() {
  return {{2874.7, 0}, {0, 1375.2}, {2874.8, 4250.1}, {5749.5, 1375.2}, {2874.7, 1375.2}};
}

struct P31Scene {
  std::vector<AssignmentMark> marks;  // px, origin in the centre of the marks' rectangle
  std::vector<int> truth;             // -1 where the true place is not among the candidates
  Eigen::Matrix2d deformed;           // pixel = deformed * place + shift
  Eigen::Vector2d shift;
  double noise = 0;

  Eigen::Vector2d TruePlace(size_t mark) const { return deformed * marks[mark].place_mm + shift; }

  // Every mark that is there is found, none that is not: within 2 px, as clutter may lie that near.
  bool IsRight(const std::vector<int>& choice) const {
    for (size_t i = 0; i < marks.size(); ++i) {
      if (choice[i] < 0 && truth[i] >= 0) return false;
      if (choice[i] < 0) continue;
      const Eigen::Vector2d& chosen = marks[i].candidates[choice[i]].position_mm;
      if ((chosen - TruePlace(i)).norm() > 2) return false;
    }
    return true;
  }

  // Largest distance at a mark between a transform and the true one, px.
  double ErrorOf(const Affine2d& transform) const {
    double most = 0;
    for (size_t i = 0; i < marks.size(); ++i)
      most = std::max(most, (transform * marks[i].place_mm - TruePlace(i)).norm());
    return most;
  }
};

struct P31Spec {
  int clutter = 6;
  double found = 1.0;
};

inline constexpr double kP31HalfRangePx = 100;

// Scanned photogrammetrically: shear and difference of scales of 1.5e-4.
inline ConstellationPrior P31Prior() {
  ConstellationPrior prior;
  prior.shift_mm = Eigen::Vector2d(40, 40);  // px all of these, not mm
  prior.turn_rad = 0.006;
  prior.scale = 1e-3;
  prior.affinity = 1.5e-4;
  prior.point_mm = 0.4;
  prior.found = 0.9;
  return prior;
}

class P31Scenes {
 public:
  explicit P31Scenes(unsigned seed) : random_(seed) {}

  P31Scene Make(const P31Spec& spec) {
    for (;;) {
      P31Scene scene = Film();
      if (FillWindows(spec, &scene)) return scene;
    }
  }

 private:
  P31Scene Film() {
    P31Scene scene;
    scene.deformed = Eigen::Rotation2Dd(0.005 * Normal()).toRotationMatrix();
    scene.deformed *= 1 + 5e-4 * Normal();
    const double d = 1.5e-4 * Normal(), e = 1.5e-4 * Normal();
    scene.deformed *= (Eigen::Matrix2d() << 1 + d / 2, e / 2, e / 2, 1 - d / 2).finished();
    scene.shift = {Uniform(-50, 50), Uniform(-50, 50)};
    scene.noise = Uniform(0.2, 0.5);
    return scene;
  }

  // False where a true mark lies outside its window.
  bool FillWindows(const P31Spec& spec, P31Scene* scene) {
    const double r = kP31HalfRangePx;
    for (const Eigen::Vector2d& mark_px : P31Marks()) {
      AssignmentMark mark{mark_px - Eigen::Vector2d(2874.75, 2125.05), {}, 4 * r * r};
      for (int k = 0; k < spec.clutter; ++k)
        mark.candidates.push_back(
            {mark.place_mm + Eigen::Vector2d(Uniform(-r, r), Uniform(-r, r)), 0});
      int truth = -1;
      if (Uniform(0, 1) < spec.found) {
        const Eigen::Vector2d at = scene->deformed * mark.place_mm + scene->shift +
                                   scene->noise * Eigen::Vector2d(Normal(), Normal());
        if ((at - mark.place_mm).cwiseAbs().maxCoeff() > r) return false;
        truth = std::uniform_int_distribution<int>(0, spec.clutter)(random_);
        mark.candidates.insert(mark.candidates.begin() + truth, {at, 0});
      }
      scene->truth.push_back(truth);
      scene->marks.push_back(std::move(mark));
    }
    return true;
  }

  double Normal() { return std::normal_distribution<double>()(random_); }
  double Uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

  std::mt19937 random_;
};

}  // namespace orient::interior
