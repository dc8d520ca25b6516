// Step 3, match: where the aligned patch lies in the photo; several answers while the pose is
// uncertain, one precise answer at the end.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/files/finding.h"
#include "core/matching/correlation.h"
#include "exterior/steps/align.h"
#include "exterior/steps/photo_image.h"
#include "exterior/steps/predict.h"

namespace orient::exterior {

// By what a patch was found: its grey values, or where the grey values of another season, film or
// decade no longer resemble it, its gradients' orientations (core/matching/gradient_channels.h).
enum class MatchCue { kGrey, kGradients };

// One place in the photo where a patch may lie.
struct Candidate {
  Eigen::Vector2d pixel;  // scan, of the patch's ground point
  double score = 0;       // NCC, or the equivalent for a correlation of gradients
};

struct CandidateOptions {
  double min_score = 0.35;
  bool gradients = false;
};

// Where the patch's ground point is searched for: within `radius_px` (col, row; scan pixels) of the
// prediction, but inside the photo, however little is known of the pose. Scan pixels.
struct SearchArea {
  Eigen::Vector2d first, last;
  Eigen::Vector2d Size() const { return (last - first).cwiseMax(0); }
};
SearchArea AreaToSearch(const Eigen::Vector2d& predicted_px, const Eigen::Vector2d& radius_px,
                        const PhotoImage& photo);

// The best places in that area: by grey values, and if asked for, unless one place stands out
// clearly, by gradients too. The aligned patch's reduction must be an integer.
std::vector<Candidate> FindCandidates(const AlignedPatch& patch, const PhotoImage& photo,
                                      const Eigen::Vector2d& radius_px,
                                      const CandidateOptions& options);

// The outcome of precise matching; pixels of the scan.
struct PreciseMatch {
  Eigen::Vector2d pixel;           // scan; meaningful where `found`
  Eigen::Matrix2d covariance_px2;  // of least-squares matching
  double ncc = 0;                  // at the least-squares position, of grey values or channels
  bool found = false;
  MatchCue cue = MatchCue::kGrey;
  Findings why_not;
};

struct PreciseOptions {
  double min_score = 0.6;
  // The second-best place must be this much worse, or the patch is ambiguous.
  double min_score_gap = 0.05;
  // An edge counts, too, across its direction: along it the place is the predicted one, and the
  // covariance says so. For windows in which no other place competes.
  bool edges = false;
};

// A patch that is searched for precisely: correlated with its window of the photo once,
// whatever is asked of it then.
class PreciseSearch {
 public:
  PreciseSearch(AlignedPatch patch, const PhotoImage& photo, const Eigen::Vector2d& radius_px);

  // NCC in the window, then least-squares matching from its peak; the two must agree.
  PreciseMatch ByGrey(const PreciseOptions& options) const;
  // The same with gradients, for when grey values fail; also, the middle of what was found must
  // be found again at its place in the patch. (With grey values, this check detects no wrong match
  // that is not detected without it, and it costs right matches.)
  PreciseMatch ByGradients() const;

 private:
  AlignedPatch patch_;
  ImageWindow window_;
  std::vector<Peak> grey_;  // at most two, the best first
};

}  // namespace orient::exterior
