#include "exterior/match.h"

#include <algorithm>
#include <cmath>

#include "core/imaging/correlation.h"
#include "core/imaging/least_squares_matching.h"

namespace orient {
namespace {

// Peaks closer than this are one peak.
constexpr double kPeakDistance = 2.5;

struct Search {
  ImageWindow window;       // the photo around the prediction
  std::vector<Peak> peaks;  // positions of the template's corner in the window
};

Search SearchWindow(const AlignedPatch& patch, const PhotoImage& photo,
                    const Eigen::Vector2d& radius_px, int max_peaks, double min_score) {
  const SearchArea area = AreaToSearch(patch.predicted_px, radius_px, photo);
  const Eigen::Vector2d half =
      area.Size() / 2 + patch.reduction * (patch.Centre() + Eigen::Vector2d::Constant(1.5));
  Search search;
  search.window =
      photo.Around((area.first + area.last) / 2, half, static_cast<int>(patch.reduction));
  const Image scores = Correlate(patch.image, search.window.image);
  if (!scores.Empty()) search.peaks = FindPeaks(scores, max_peaks, kPeakDistance, min_score);
  return search;
}

Eigen::Vector2d ScanFromPeak(const AlignedPatch& patch, const Search& search, const Peak& peak) {
  return search.window.RasterFromImage(peak.position + patch.Centre());
}

PreciseMatch NotFound(const std::string& reason) {
  PreciseMatch match;
  match.reason = reason;
  return match;
}

}  // namespace

SearchArea AreaToSearch(const Eigen::Vector2d& predicted_px, const Eigen::Vector2d& radius_px,
                        const PhotoImage& photo) {
  const Eigen::Vector2d corner(photo.Width(), photo.Height());
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  return {(predicted_px - radius_px).cwiseMax(none).cwiseMin(corner),
          (predicted_px + radius_px).cwiseMax(none).cwiseMin(corner)};
}

std::vector<Candidate> FindCandidates(const AlignedPatch& patch, const PhotoImage& photo,
                                      const Eigen::Vector2d& radius_px,
                                      const CandidateOptions& options) {
  const Search search =
      SearchWindow(patch, photo, radius_px, options.max_candidates, options.min_score);
  std::vector<Candidate> candidates;
  for (const Peak& peak : search.peaks)
    candidates.push_back({ScanFromPeak(patch, search, peak), peak.score});
  return candidates;
}

PreciseMatch MatchPrecisely(const AlignedPatch& patch, const PhotoImage& photo,
                            const Eigen::Vector2d& radius_px, const PreciseOptions& options) {
  const Search search = SearchWindow(patch, photo, radius_px, 2, options.min_score / 2);
  if (search.peaks.empty()) return NotFound("no correlation peak in the search window");
  const Peak& best = search.peaks.front();
  if (best.score < options.min_score) return NotFound("best correlation below the threshold");
  if (search.peaks.size() > 1 && best.score - search.peaks[1].score < options.min_score_gap)
    return NotFound("ambiguous: a second place correlates as well");

  LsmOptions lsm;
  lsm.geometry = LsmGeometry::kShift;
  lsm.max_shift_px = 2;
  const auto fit = MatchLeastSquares(patch.image, search.window.image, patch.Centre(),
                                     Affine2d{Eigen::Matrix2d::Identity(), best.position}, lsm);
  if (!fit) return NotFound("least-squares matching did not converge");
  if (fit->gain <= 0 || fit->correlation < options.min_score)
    return NotFound("least-squares matching found another texture");
  const Eigen::Vector2d peak = best.position + patch.Centre();
  if ((fit->position - peak).norm() > options.max_disagreement_px)
    return NotFound("correlation and least-squares matching disagree");
  if (std::sqrt(fit->covariance.trace() / 2) > options.max_sigma_px)
    return NotFound("texture too weak for a precise position");

  PreciseMatch match;
  match.pixel = search.window.RasterFromImage(fit->position);
  match.covariance_px2 = fit->covariance * patch.reduction * patch.reduction;
  match.ncc = fit->correlation;
  match.found = true;
  return match;
}

}  // namespace orient
