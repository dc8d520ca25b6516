#include "block/bundle/gnss_shift.h"

#include <Eigen/Dense>

#include "block/bundle/shared_errors.h"
#include "block/bundle/variance_components.h"
#include "core/base/chi_square.h"

namespace orient::block {
namespace {

// A shift wrongly taken for an error costs some precision; an error that is not recognised, such as
// one just below the limit of data snooping, is a false datum of all poses.
constexpr double kSignificance = 0.01;
// Variance factor at which approximations used as observations hardly contribute, but still hold
// what nothing else holds.
constexpr double kNextToNothing = 1e4;

// Covariance of the common GNSS shift, essentially as determined by control, m^2.
Eigen::Matrix3d CovarianceByControl(const BlockTests& tests, const BlockNormals& as_weighted,
                                    BlockSystem* system) {
  const Eigen::MatrixXd moved = UnknownsMovedByControl(*system, as_weighted, tests);
  const StatedPrecision stated(system);
  system->SetFactor(RowKind::kPosePrior, kNextToNothing * system->Factor(RowKind::kPosePrior));
  const BlockNormals normals(*system, 0);
  const Eigen::Index first = 6 * static_cast<Eigen::Index>(system->common_gnss_shift.group);
  const auto unknowns = 6 * static_cast<Eigen::Index>(system->groups.size());
  Eigen::Matrix3d covariance;
  for (int i = 0; i < 3; ++i)
    covariance.col(i) =
        normals.cholesky().Solve(Eigen::VectorXd::Unit(unknowns, first + i)).segment<3>(first);
  if (moved.size() == 0) return covariance;
  return covariance + moved.middleRows<3>(first) * moved.middleRows<3>(first).transpose();
}

bool CanBeTested(const std::vector<bool>& takes_part, const BlockSystem& system) {
  constexpr std::ptrdiff_t kLeastControl = 3;
  std::ptrdiff_t used = 0, observed = 0, control = 0;
  for (std::size_t photo = 0; photo < takes_part.size(); ++photo) {
    const int row = system.gnss_row[photo];
    if (row < 0 || !takes_part[photo]) continue;
    ++observed;
    used += system.IsActive(static_cast<std::size_t>(row)) ? 1 : 0;
  }
  for (std::size_t point = 0; point < system.points.size(); ++point)
    control += system.HasControl(point) && system.Rays(point) > 0 ? 1 : 0;
  return 2 * used > observed && control >= kLeastControl;
}

}  // namespace

bool HoldCommonGnssShiftIfInsignificant(const BlockTests& tests, const BlockNormals& as_weighted,
                                        const std::vector<bool>& takes_part, BlockSystem* system) {
  if (!system->EstimatesCommonGnssShift()) return false;
  const Eigen::Vector3d shift_m =
      system->groups[static_cast<std::size_t>(system->common_gnss_shift.group)].head<3>();
  if (CanBeTested(takes_part, *system)) {
    const Eigen::LDLT<Eigen::Matrix3d> covariance(CovarianceByControl(tests, as_weighted, system));
    if (shift_m.dot(covariance.solve(shift_m)) > ChiSquareLimit(3, kSignificance)) return false;
  }
  system->HoldCommonGnssShift();
  return true;
}

}  // namespace orient::block
