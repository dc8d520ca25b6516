#include "block/roll/roll.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "core/base/median.h"
#include "core/files/used_marks.h"
#include "interior/orientation/film_transform.h"

namespace orient::block {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kLeastMarks = 4;
constexpr double kLeastAffinity = 2e-4;  // a film's own shrinkage varies by about half of it
constexpr double kLeastSigma0_um = 5;
constexpr double kPhotogrammetricAffinity = 5e-4;
constexpr double kPhotogrammetricSigma0_um = 30;
constexpr double kLeastSystematic_um = 1;
constexpr double kChanceOfOneRoll = 1e-3;  // that any of a roll's marks looks systematic by chance
bool Counts(const InteriorResult& result) {
  return result.status != Status::kFailed && result.photo_from_pixel && result.sigma0_um &&
         std::isfinite(*result.sigma0_um) && CountUsedMarks(result) >= kLeastMarks;
}

// Probability that Hotelling's T^2 of n vectors of two components exceeds this value by chance:
// (n - 2) / (2 (n - 1)) T^2 is F distributed with 2 and n - 2 degrees of freedom, whose upper tail
// is (1 + 2 F / (n - 2))^-((n - 2) / 2).
double ChanceOf(double t_squared, int n) {
  return std::pow(1 + t_squared / (n - 1), -0.5 * (n - 2));
}

RollMark StatisticsOfMark(const std::string& id, const std::vector<Vector2d>& residuals,
                          double significant) {
  RollMark mark;
  mark.id = id;
  mark.photos = static_cast<int>(residuals.size());
  if (mark.photos < kLeastPhotosOfRoll) return mark;
  for (const Vector2d& r : residuals) mark.mean_um += r / mark.photos;
  Matrix2d covariance = Matrix2d::Zero();
  for (const Vector2d& r : residuals)
    covariance += (r - mark.mean_um) * (r - mark.mean_um).transpose() / (mark.photos - 1.0);
  covariance /= mark.photos;
  mark.sigma_um = covariance.diagonal().cwiseSqrt();
  covariance += 1e-8 * Matrix2d::Identity();  // residuals without any noise
  const double t_squared = mark.mean_um.dot(covariance.inverse() * mark.mean_um);
  mark.probability = ChanceOf(t_squared, mark.photos);
  mark.systematic = mark.probability < significant && mark.mean_um.norm() > kLeastSystematic_um;
  return mark;
}

std::vector<RollMark> StatisticsOfMarks(const std::vector<const InteriorResult*>& photos) {
  std::vector<RollMark> marks;
  const size_t count = photos.front()->marks.size();
  for (size_t i = 0; i < count; ++i) {
    std::vector<Vector2d> residuals;
    for (const InteriorResult* photo : photos)
      if (i < photo->marks.size() && photo->marks[i].state == MarkState::kUsed &&
          photo->marks[i].residual_um)
        residuals.push_back(*photo->marks[i].residual_um);
    marks.push_back(StatisticsOfMark(photos.front()->marks[i].id, residuals,
                                     kChanceOfOneRoll / static_cast<double>(count)));
  }
  return marks;
}

bool IsOfRoll(const Finding& finding) {
  switch (finding.reason) {
    case Reason::kRollPixelColumns:
    case Reason::kRollPixelRows:
    case Reason::kRollScaleDifference:
    case Reason::kRollShear:
    case Reason::kRollSigma0:
      return true;
    default:
      return false;
  }
}

// Removes the findings of an earlier comparison and restores the status.
void Forget(InteriorResult* result) {
  if (result->status_alone) result->status = *result->status_alone;
  result->status_alone.reset();
  std::erase_if(result->findings, IsOfRoll);
}

}  // namespace

std::optional<RollStatistics> StatisticsOfRoll(const std::vector<InteriorResult>& results) {
  std::vector<const InteriorResult*> photos;
  std::vector<double> column, row, difference, shear, sigma0;
  for (const InteriorResult& result : results) {
    if (!Counts(result)) continue;
    photos.push_back(&result);
    const interior::FilmShape shape = interior::ShapeOf(*result.photo_from_pixel);
    column.push_back(shape.column_um);
    row.push_back(shape.row_um);
    difference.push_back(shape.scale_difference);
    shear.push_back(shape.shear_rad);
    sigma0.push_back(*result.sigma0_um);
  }
  if (photos.size() < static_cast<size_t>(kLeastPhotosOfRoll)) return std::nullopt;
  RollStatistics roll;
  roll.photos = static_cast<int>(photos.size());
  roll.column_um = Robust(column);
  roll.row_um = Robust(row);
  roll.scale_difference = Robust(difference);
  roll.shear_rad = Robust(shear);
  roll.sigma0_um = Robust(sigma0);
  roll.photogrammetric = std::abs(roll.scale_difference.median) < kPhotogrammetricAffinity &&
                         std::abs(roll.shear_rad.median) < kPhotogrammetricAffinity &&
                         roll.sigma0_um.median < kPhotogrammetricSigma0_um;
  roll.marks = StatisticsOfMarks(photos);
  return roll;
}

namespace {

// As reported: one more photo in the roll must not change the others' results in the last digit.
double Rounded(double value) { return std::round(1e3 * value) / 1e3; }

}  // namespace

Findings WhyItStandsOut(const RollStatistics& roll, const InteriorResult& photo) {
  Findings findings;
  if (!Counts(photo)) return findings;
  const double sigmas = 5 + 80.0 / roll.photos;
  const auto compare = [&](Reason reason, double departure, const RobustValue& value, double least,
                           double own, double scale) {
    if (departure > least && departure > sigmas * value.sigma)
      findings.push_back(
          {reason, Status::kWeak, Rounded(scale * own), Rounded(scale * value.median)});
  };
  const auto compare_size = [&](Reason reason, double size, const RobustValue& value) {
    compare(reason, std::abs(size - value.median), value, kLeastAffinity * value.median, size, 1);
  };
  const interior::FilmShape shape = interior::ShapeOf(*photo.photo_from_pixel);
  compare_size(Reason::kRollPixelColumns, shape.column_um, roll.column_um);
  compare_size(Reason::kRollPixelRows, shape.row_um, roll.row_um);
  compare(Reason::kRollScaleDifference,
          std::abs(shape.scale_difference - roll.scale_difference.median), roll.scale_difference,
          kLeastAffinity, shape.scale_difference, 100);
  compare(Reason::kRollShear, std::abs(shape.shear_rad - roll.shear_rad.median), roll.shear_rad,
          kLeastAffinity, shape.shear_rad, 1e3);
  compare(Reason::kRollSigma0, *photo.sigma0_um - roll.sigma0_um.median, roll.sigma0_um,
          kLeastSigma0_um, *photo.sigma0_um, 1);
  return findings;
}

std::vector<size_t> CompareWithRoll(const std::optional<RollStatistics>& roll,
                                    std::vector<InteriorResult>* results) {
  std::vector<size_t> changed;
  for (size_t i = 0; i < results->size(); ++i) {
    InteriorResult& result = (*results)[i];
    const InteriorResult before = result;
    Forget(&result);
    const bool compared = roll && !Has(result.findings, Reason::kAcceptedByPerson);
    const Findings findings = compared ? WhyItStandsOut(*roll, result) : Findings();
    if (!findings.empty() && result.status == Status::kOk) {
      result.status_alone = Status::kOk;
      result.status = Status::kWeak;
    }
    result.findings.insert(result.findings.end(), findings.begin(), findings.end());
    if (result.status != before.status || result.findings != before.findings) changed.push_back(i);
  }
  return changed;
}

std::vector<std::string> RollSentences(const RollStatistics& roll) {
  std::vector<std::string> findings;
  const double um = 0.5 * (roll.column_um.median + roll.row_um.median);
  findings.push_back(fmt::format(
      "{} photos of one roll: pixel {:.4f} um (+- {:.3f} %), scales differ by {:.3f} %, shear "
      "{:.2f} mrad, sigma0 {:.1f} um: {}.",
      roll.photos, um, 100 * std::max(roll.column_um.sigma, roll.row_um.sigma) / um,
      100 * roll.scale_difference.median, 1e3 * roll.shear_rad.median, roll.sigma0_um.median,
      roll.photogrammetric ? "a photogrammetric scanner"
                           : "a desktop scanner, prints, or a camera file that does not fit"));
  const auto used = std::count_if(roll.marks.begin(), roll.marks.end(), [](const RollMark& mark) {
    return mark.photos >= kLeastPhotosOfRoll;
  });
  bool any = false;
  for (const RollMark& mark : roll.marks) {
    if (!mark.systematic) continue;
    any = true;
    findings.push_back(
        fmt::format("Mark {} lies off its calibrated position by ({:.1f}, {:.1f}) um (sigma "
                    "{:.1f}, {:.1f}) on average over {} photos.",
                    mark.id, -mark.mean_um.x(), -mark.mean_um.y(), mark.sigma_um.x(),
                    mark.sigma_um.y(), mark.photos));
  }
  if (any && used <= kLeastMarks)
    findings.emplace_back(
        "With four marks an affine distributes one mark's error over all four: the wrong position "
        "in the camera file cannot be identified.");
  if (any)
    findings.emplace_back(
        "The camera file's positions or the scanner's distortion cause this; 'orient interior "
        "estimate-camera' estimates the positions from these photos.");
  return findings;
}

}  // namespace orient::block
