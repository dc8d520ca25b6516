#include "block/bundle/costs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/geometry/collinearity.h"
#include "core/geometry/dense_solvers.h"

namespace orient::block {
namespace {

// Residual of a point behind the camera: far larger than any gross error, yet finite, so that one
// lost point does not stop the others.
constexpr double kBehind = 1e4;

using RowMajor23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using RowMajor26 = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;
using RowMajor36 = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;
using RowMajor66 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajorX6 = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

class Cost : public ceres::CostFunction {
 protected:
  void SetSizes(int residuals, const std::vector<int>& blocks) {
    set_num_residuals(residuals);
    mutable_parameter_block_sizes()->assign(blocks.begin(), blocks.end());
  }
};

class ImageCost : public Cost {
 public:
  ImageCost(const ImageOfPhoto& photo, const Eigen::Vector3d& start_m,
            const ImageMeasurement& measured, const double* weight)
      : photo_(photo), start_m_(start_m), measured_(measured), weight_(weight) {
    whitening_ = WhiteningOf(measured.covariance_mm2, "an image observation");
    std::vector<int> sizes = {3, 6};
    if (photo.has_film) sizes.push_back(6);
    if (photo.lens != nullptr) sizes.push_back(6);
    SetSizes(2, sizes);
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> point(x[0]);
    const Eigen::Map<const Vector6d> pose(x[1]);
    const Pose now{photo_.start.position_m + pose.head<3>(), photo_.start.opk_rad + pose.tail<3>()};
    const auto seen = PhotoFromGroundWithDerivatives(*photo_.camera, now, start_m_ + point);
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    if (!seen) return Behind(&residual, jacobians);
    Eigen::Vector2d off = seen->photo_mm - measured_.photo_mm;
    const Eigen::Matrix2d whitening = *weight_ * whitening_;
    int block = 2;
    if (photo_.has_film) {
      const Eigen::Matrix<double, 2, 6> by_film = ByFilm();
      off -= by_film * Eigen::Map<const Vector6d>(x[block]);
      if (Wanted(jacobians, block)) Eigen::Map<RowMajor26>{jacobians[block]} = -whitening * by_film;
      ++block;
    }
    if (photo_.lens != nullptr) {
      const Eigen::Matrix<double, 2, 6> by_lens = ByLens(*seen, now, start_m_ + point);
      off += by_lens * Eigen::Map<const Vector6d>(x[block]);
      if (Wanted(jacobians, block)) Eigen::Map<RowMajor26>{jacobians[block]} = whitening * by_lens;
    }
    residual = whitening * off;
    if (Wanted(jacobians, 0)) Eigen::Map<RowMajor23>{jacobians[0]} = whitening * seen->by_ground;
    if (Wanted(jacobians, 1)) Eigen::Map<RowMajor26>{jacobians[1]} = whitening * seen->by_pose;
    return true;
  }

 private:
  static bool Wanted(double** jacobians, int block) {
    return jacobians != nullptr && jacobians[block] != nullptr;
  }

  bool Behind(Eigen::Map<Eigen::Vector2d>* residual, double** jacobians) const {
    residual->setConstant(kBehind);
    for (int i = 0; i < static_cast<int>(parameter_block_sizes().size()); ++i)
      if (Wanted(jacobians, i))
        std::fill_n(jacobians[i], 2 * parameter_block_sizes()[static_cast<std::size_t>(i)], 0.0);
    return true;
  }

  // photo = A pixel + t: effect of errors of A and t on the measured photo coordinates.
  Eigen::Matrix<double, 2, 6> ByFilm() const {
    Eigen::Matrix<double, 2, 6> by;
    by << measured_.pixel.x(), measured_.pixel.y(), 0, 0, 1, 0,  //
        0, 0, measured_.pixel.x(), measured_.pixel.y(), 0, 1;
    return by * photo_.film_root;
  }

  Eigen::Matrix<double, 2, 6> ByLens(const ProjectionDerivatives& seen, const Pose& pose,
                                     const Eigen::Vector3d& point) const {
    const Eigen::Vector3d d = pose.GroundFromPhoto().transpose() * (point - pose.position_m);
    const Eigen::Vector2d ideal = d.head<2>() * (-photo_.camera->principal_distance_mm / d.z());
    const double r2 = ideal.squaredNorm();
    Eigen::Matrix<double, 2, 6> by;
    by << seen.by_principal_distance, Eigen::Matrix2d::Identity(), ideal * r2, ideal * r2 * r2,
        ideal * r2 * r2 * r2;
    for (int i = 0; i < 6; ++i)
      by.col(i) *= photo_.lens->active[static_cast<std::size_t>(i)] ? photo_.lens->unit[i] : 0.0;
    return by;
  }

  const ImageOfPhoto& photo_;
  const Eigen::Vector3d& start_m_;
  ImageMeasurement measured_;
  Eigen::Matrix2d whitening_;
  const double* weight_;
};

class ControlCost : public Cost {
 public:
  ControlCost(const ControlTerm& term, bool third_row, const double* weight)
      : offset_m_(term.offset_m), effect_m_(term.effect_m), weight_(weight) {
    whitening_.setZero();
    if (third_row)
      whitening_.row(0) = term.whitening.row(2);
    else
      whitening_ = term.whitening.topRows<2>();
    std::vector<int> sizes = {3};
    for (const int element : {term.common_element, term.cell_element}) {
      elements_.at(sizes.size() - 1) = element;
      if (element >= 0) sizes.push_back(6);
    }
    SetSizes(2, sizes);
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Matrix<double, 2, 3> whitening = *weight_ * whitening_;
    Eigen::Vector3d off = offset_m_ + Eigen::Map<const Eigen::Vector3d>(x[0]);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMajor23>{jacobians[0]} = whitening;
    for (std::size_t i = 1; i < parameter_block_sizes().size(); ++i) {
      const int element = elements_.at(i - 1);
      off -= effect_m_ * x[i][element];
      if (jacobians == nullptr || jacobians[i] == nullptr) continue;
      Eigen::Map<RowMajor26> jacobian(jacobians[i]);
      jacobian.setZero();
      jacobian.col(element) = -whitening * effect_m_;
    }
    Eigen::Map<Eigen::Vector2d>{residuals} = whitening * off;
    return true;
  }

 private:
  Eigen::Vector3d offset_m_, effect_m_;
  Eigen::Matrix<double, 2, 3> whitening_;
  std::array<int, 2> elements_ = {-1, -1};
  const double* weight_;
};

// One residual for each stated element: elements that are not observed have no redundancy.
class PosePriorCost : public Cost {
 public:
  PosePriorCost(const PosePrior& prior, const Pose& start, const double* weight)
      : offset_(PoseDifference(start, prior.pose)), weight_(weight) {
    const auto stated = StatedElements(prior);
    const auto rows = static_cast<Eigen::Index>(stated.size());
    whitening_.setZero(rows, 6);
    whitening_(Eigen::all, stated) = WhiteningOf(prior.covariance(stated, stated), "a pose prior");
    SetSizes(static_cast<int>(rows), {6});
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const RowMajorX6 whitening = *weight_ * whitening_;
    Eigen::Map<Eigen::VectorXd>(residuals, whitening.rows()) =
        whitening * (offset_ + Eigen::Map<const Vector6d>(x[0]));
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMajorX6>(jacobians[0], whitening.rows(), 6) = whitening;
    return true;
  }

 private:
  Vector6d offset_;
  RowMajorX6 whitening_;
  const double* weight_;
};

class GnssCost : public Cost {
 public:
  GnssCost(const GnssTerm& term, const double* weight) : term_(term), weight_(weight) {
    if (term.has_shift)
      SetSizes(3, {6, 6});
    else
      SetSizes(3, {6});
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Matrix3d whitening = *weight_ * term_.whitening;
    Eigen::Vector3d off = term_.offset_m + Eigen::Map<const Eigen::Vector3d>(x[0]);
    if (term_.has_shift)
      off += Eigen::Map<const Eigen::Vector3d>(x[1]) +
             term_.time * Eigen::Map<const Eigen::Vector3d>(x[1] + 3);
    Eigen::Map<Eigen::Vector3d>{residuals} = whitening * off;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr)
      Eigen::Map<RowMajor36>{jacobians[0]} << whitening, Eigen::Matrix3d::Zero();
    if (term_.has_shift && jacobians[1] != nullptr)
      Eigen::Map<RowMajor36>{jacobians[1]} << whitening, term_.time * whitening;
    return true;
  }

 private:
  GnssTerm term_;
  const double* weight_;
};

class ZeroCost : public Cost {
 public:
  ZeroCost(const Vector6d& sigma, const double* weight)
      : whitening_(sigma.cwiseInverse()), weight_(weight) {
    SetSizes(6, {6});
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Vector6d weights = *weight_ * whitening_;
    Eigen::Map<Vector6d>{residuals} = weights.cwiseProduct(Eigen::Map<const Vector6d>(x[0]));
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMajor66>{jacobians[0]} = weights.asDiagonal();
    return true;
  }

 private:
  Vector6d whitening_;
  const double* weight_;
};

}  // namespace

Eigen::MatrixXd WhiteningOf(const Eigen::MatrixXd& covariance, const char* what) {
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  if (cholesky.info() != Eigen::Success || !covariance.allFinite())
    throw std::invalid_argument(std::string("the covariance of ") + what +
                                " is not positive definite");
  return cholesky.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

std::unique_ptr<ceres::CostFunction> MakeImageCost(const ImageOfPhoto& photo,
                                                   const Eigen::Vector3d& start_m,
                                                   const ImageMeasurement& measured,
                                                   const double* weight) {
  return std::make_unique<ImageCost>(photo, start_m, measured, weight);
}

std::unique_ptr<ceres::CostFunction> MakeControlCost(const ControlTerm& term, bool third_row,
                                                     const double* weight) {
  return std::make_unique<ControlCost>(term, third_row, weight);
}

std::unique_ptr<ceres::CostFunction> MakePosePriorCost(const PosePrior& prior, const Pose& start,
                                                       const double* weight) {
  return std::make_unique<PosePriorCost>(prior, start, weight);
}

std::unique_ptr<ceres::CostFunction> MakeGnssCost(const GnssTerm& term, const double* weight) {
  return std::make_unique<GnssCost>(term, weight);
}

std::unique_ptr<ceres::CostFunction> MakeZeroCost(const Vector6d& sigma, const double* weight) {
  return std::make_unique<ZeroCost>(sigma, weight);
}

}  // namespace orient::block
