#include "block/verdict/own_patches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "exterior/steps/error_model.h"

namespace orient::block {
namespace {

constexpr int kFewest = 30;
constexpr double kMuchWorse = 2.5;
constexpr double kLeast_px = 0.2;

bool HasResidual(const PatchResult& patch) {
  const bool of_edge =
      patch.sigma_px && patch.sigma_px->maxCoeff() > exterior::kLeastSigmaOfEdge_px;
  return patch.state == PatchState::kMatched && patch.residual_px &&
         patch.residual_px->allFinite() && !of_edge;
}

}  // namespace

OwnPatches OwnPatchesOf(const std::vector<PatchResult>& alone,
                        const std::vector<PatchResult>& block) {
  std::map<std::int64_t, Eigen::Vector2d> before_px;
  for (const PatchResult& patch : alone)
    if (HasResidual(patch)) before_px[patch.id] = *patch.residual_px;
  OwnPatches own;
  double alone_px2 = 0, block_px2 = 0;
  for (const PatchResult& patch : block) {
    own.contradicting +=
        std::any_of(patch.findings.begin(), patch.findings.end(),
                    [](const Finding& f) { return f.reason == Reason::kPatchContradictsBlock; });
    const auto before = before_px.find(patch.id);
    if (before == before_px.end() || !HasResidual(patch)) continue;
    ++own.used;
    alone_px2 += before->second.squaredNorm() / 2;
    block_px2 += patch.residual_px->squaredNorm() / 2;
  }
  if (own.used == 0) return own;
  own.alone_rms_px = std::sqrt(alone_px2 / own.used);
  own.rms_px = std::sqrt(block_px2 / own.used);
  return own;
}

bool IsHeldOff(const OwnPatches& patches) {
  return patches.used >= kFewest && patches.rms_px > kMuchWorse * patches.alone_rms_px &&
         patches.rms_px > std::hypot(patches.alone_rms_px, kLeast_px);
}

}  // namespace orient::block
