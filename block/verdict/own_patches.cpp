#include "block/verdict/own_patches.h"

#include <algorithm>
#include <cmath>

namespace orient::block {
namespace {

constexpr int kFewest = 30;
constexpr double kMuchWorse = 2.5;  // blocks of sources that fit one another: up to 2.2
constexpr double kLeast_px = 0.2;

}  // namespace

OwnPatches OwnPatchesOf(const std::vector<PatchResult>& patches) {
  OwnPatches own;
  double sum_px2 = 0;
  for (const PatchResult& patch : patches) {
    own.contradicting +=
        std::any_of(patch.findings.begin(), patch.findings.end(),
                    [](const Finding& f) { return f.reason == Reason::kPatchContradictsBlock; });
    if (patch.state != PatchState::kMatched || !patch.residual_px) continue;
    ++own.used;
    sum_px2 += patch.residual_px->squaredNorm() / 2;
  }
  if (own.used > 0) own.rms_px = std::sqrt(sum_px2 / own.used);
  return own;
}

bool IsHeldOff(const OwnPatches& patches, double sigma0_px) {
  return patches.used >= kFewest && patches.rms_px > kMuchWorse * sigma0_px &&
         patches.rms_px > std::hypot(sigma0_px, kLeast_px);
}

}  // namespace orient::block
