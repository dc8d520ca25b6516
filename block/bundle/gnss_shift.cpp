#include "block/bundle/gnss_shift.h"

#include <Eigen/Dense>

#include "block/bundle/shared_errors.h"
#include "block/bundle/variance_components.h"
#include "core/base/chi_square.h"

namespace orient::block {
namespace {

// What is taken for an error that it is not costs some precision; what is not, as one just below
// the limit of data snooping, is a false datum of all poses.
constexpr double kSignificance = 0.01;
// In variance, by which approximations as observations say next to nothing and hold what only they
// do.
constexpr double kNextToNothing = 1e4;

// Of the shift, m^2.
Eigen::Matrix3d CovarianceByControl(const BlockTests& tests, BlockSystem* system) {
  const StatedPrecision stated(system);
  system->SetFactor(RowKind::kPosePrior, kNextToNothing * system->Factor(RowKind::kPosePrior));
  const BlockNormals normals(*system, 0);
  const Eigen::Index first = 6 * static_cast<Eigen::Index>(system->common_gnss_shift.group);
  const auto unknowns = 6 * static_cast<Eigen::Index>(system->groups.size());
  Eigen::Matrix3d covariance;
  for (int i = 0; i < 3; ++i)
    covariance.col(i) =
        normals.cholesky().Solve(Eigen::VectorXd::Unit(unknowns, first + i)).segment<3>(first);
  const Eigen::MatrixXd moved = UnknownsMovedByControl(*system, normals, tests);
  if (moved.size() == 0) return covariance;
  return covariance + moved.middleRows<3>(first) * moved.middleRows<3>(first).transpose();
}

bool IsSignificant(const BlockTests& tests, BlockSystem* system) {
  std::ptrdiff_t used = 0, observed = 0;
  for (const int row : system->gnss_row) {
    observed += row >= 0 ? 1 : 0;
    used += row >= 0 && system->IsActive(static_cast<std::size_t>(row)) ? 1 : 0;
  }
  if (2 * used <= observed) return false;
  const Eigen::Vector3d shift_m =
      system->groups[static_cast<std::size_t>(system->common_gnss_shift.group)].head<3>();
  const Eigen::LDLT<Eigen::Matrix3d> covariance(CovarianceByControl(tests, system));
  return shift_m.dot(covariance.solve(shift_m)) > ChiSquareLimit(3, kSignificance);
}

}  // namespace

bool HoldCommonGnssShiftIfInsignificant(const BlockTests& tests, BlockSystem* system) {
  if (!system->EstimatesCommonGnssShift() || IsSignificant(tests, system)) return false;
  system->HoldCommonGnssShift();
  return true;
}

}  // namespace orient::block
