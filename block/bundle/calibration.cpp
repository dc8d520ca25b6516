#include "block/bundle/calibration.h"

#include <algorithm>
#include <cmath>

namespace orient::block {
namespace {

constexpr double kSignificant_t = 3;  // |value| / sigma from which a parameter is significant
constexpr std::array<const char*, 6> kNames = {
    kPrincipalDistanceName, "principal_point_x_mm", "principal_point_y_mm", "k1", "k2", "k3"};
// Share of the prior sigma: a parameter with a larger sigma is not determined by the block.
constexpr double kNotDetermined = 0.5;

// The six unknowns of one camera, and what they would be with some of them left out.
struct Lens {
  Vector6d value;
  Matrix6d covariance;
  std::array<bool, 6> active;

  void LeaveOut(int i) {
    const Vector6d column = covariance.col(i);
    value -= column * (value[i] / column[i]);
    covariance -= column * column.transpose() / column[i];
    active.at(static_cast<std::size_t>(i)) = false;
  }
  double Sigma(int i) const { return std::sqrt(std::max(covariance(i, i), 0.0)); }
  double T(int i) const { return std::abs(value[i]) / Sigma(i); }
  bool Active(int i) const { return active.at(static_cast<std::size_t>(i)); }

  // The active parameter with the largest `measure`; -1 if `measure` exceeds `limit` for none.
  template <typename Measure>
  int Worst(double limit, const Measure& measure) const {
    int worst = -1;
    for (int i = 0; i < 6; ++i)
      if (Active(i) && measure(i) > limit && (worst < 0 || measure(i) >= measure(worst))) worst = i;
    return worst;
  }
};

}  // namespace

void StartCalibration(BlockSystem* system) {
  for (LensUnknowns& lens : system->lens) lens.active.fill(system->options.self_calibration);
}

bool TestCalibration(const BlockNormals& normals, BlockSystem* system,
                     std::vector<CalibrationParameter>* parameters) {
  bool changed = false;
  if (parameters->empty())
    for (std::size_t camera = 0; camera < system->lens.size(); ++camera)
      for (const char* name : kNames) parameters->push_back({camera, name});
  for (std::size_t camera = 0; camera < system->lens.size(); ++camera) {
    const int group = system->lens_group[camera];
    LensUnknowns& unknowns = system->lens[camera];
    Vector6d& values = system->groups[static_cast<std::size_t>(group)];
    Lens lens{values, normals.Covariance(group), unknowns.active};
    const auto leave_out = [&](int i, CalibrationState state) {
      CalibrationParameter& parameter = (*parameters)[6 * camera + static_cast<std::size_t>(i)];
      parameter.state = state;
      parameter.sigma = lens.Sigma(i) * unknowns.unit[i];
      parameter.t = lens.T(i);
      lens.LeaveOut(i);
      changed = true;
    };
    for (int i; (i = lens.Worst(kNotDetermined, [&](int k) { return lens.Sigma(k); })) >= 0;)
      leave_out(i, CalibrationState::kNotDetermined);
    const double limit = 1 / kSignificant_t;
    for (int i; (i = lens.Worst(limit, [&](int k) { return 1 / lens.T(k); })) >= 0;)
      leave_out(i, CalibrationState::kInsignificant);
    unknowns.active = lens.active;
    for (int i = 0; i < 6; ++i) {
      values[i] = lens.Active(i) ? lens.value[i] : 0;
      if (!lens.Active(i)) continue;
      (*parameters)[6 * camera + static_cast<std::size_t>(i)] = {
          camera,
          kNames.at(static_cast<std::size_t>(i)),
          values[i] * unknowns.unit[i],
          lens.Sigma(i) * unknowns.unit[i],
          lens.T(i),
          CalibrationState::kEstimated};
    }
  }
  return changed;
}

std::vector<Camera> CalibratedCameras(const BlockSystem& system) {
  std::vector<Camera> cameras = system.block.cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (system.lens_group[i] < 0) continue;
    const Vector6d value =
        system.groups[static_cast<std::size_t>(system.lens_group[i])].cwiseProduct(
            system.lens[i].unit);
    Camera& camera = cameras[i];
    camera.principal_distance_mm += value[0];
    camera.principal_point_mm += value.segment<2>(1);
    if (value.tail<3>().isZero(0)) continue;
    camera.lens =
        WithRadial(camera.lens, {value[3], value[4], value[5]}, 1.2 * camera.FrameRadius());
  }
  return cameras;
}

}  // namespace orient::block
