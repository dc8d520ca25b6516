#include "block/verdict/own_patches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

#include "exterior/steps/error_model.h"

namespace orient::block {
namespace {

constexpr int kFewest = 30;
constexpr double kMuchWorse = 2.5;
constexpr double kLeast_px = 0.2;
constexpr double kTail = 3;

bool HasResidual(const PatchResult& patch) {
  return patch.state == PatchState::kMatched && patch.residual_px &&
         patch.residual_px->allFinite() && !(patch.sigma_px && exterior::IsOfEdge(*patch.sigma_px));
}

}  // namespace

OwnPatches OwnPatchesOf(const std::vector<PatchResult>& alone,
                        const std::vector<PatchResult>& block) {
  std::map<std::int64_t, Eigen::Vector2d> before_px;
  for (const PatchResult& patch : alone)
    if (HasResidual(patch)) before_px[patch.id] = *patch.residual_px;
  OwnPatches own;
  double alone_px2 = 0, block_px2 = 0;
  std::vector<double> rejected_px;
  for (const PatchResult& patch : block) {
    if (patch.residual_px && Has(patch.findings, Reason::kPatchContradictsBlock))
      rejected_px.push_back(patch.residual_px->norm());
    const auto before = before_px.find(patch.id);
    if (before == before_px.end() || !HasResidual(patch)) continue;
    ++own.used;
    alone_px2 += before->second.squaredNorm() / 2;
    block_px2 += patch.residual_px->squaredNorm() / 2;
  }
  own.rejected = static_cast<int>(rejected_px.size());
  if (own.used == 0) return own;
  own.alone_rms_px = std::sqrt(alone_px2 / own.used);
  own.rms_px = std::sqrt(block_px2 / own.used);
  const double most_px = kTail * std::numbers::sqrt2 * own.rms_px;
  own.misfitting = static_cast<int>(std::count_if(rejected_px.begin(), rejected_px.end(),
                                                  [&](double px) { return px <= most_px; }));
  return own;
}

bool IsHeldOff(const OwnPatches& patches) {
  return patches.used >= kFewest && patches.rms_px > kMuchWorse * patches.alone_rms_px &&
         patches.rms_px > std::hypot(patches.alone_rms_px, kLeast_px);
}

}  // namespace orient::block
