#include "interior/orientation/vote_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace orient::interior {
namespace {

std::string SymbolOf(const std::string& mark) { return "symbol of mark " + mark; }

}  // namespace

VoteNames::VoteNames(const CameraFile& camera, const MarkShapes& shapes, ScanOrientation first,
                     ScanOrientation chosen)
    : camera_(camera), relabel_(Relabel(camera.fiducials, shapes, first, chosen)) {}

std::string VoteNames::Of(const std::vector<OrientationVote>& votes,
                          const std::vector<size_t>& which) const {
  std::vector<std::string> marks, named;
  bool border = false, layout = false;
  for (const size_t i : which) {
    if (votes[i].mark)
      marks.push_back(MarkOf(votes[i]));
    else
      (votes[i].layout ? layout : border) = true;
  }
  if (!marks.empty())
    named.push_back(fmt::format("the symbol{} of mark{} {}", marks.size() > 1 ? "s" : "",
                                marks.size() > 1 ? "s" : "", fmt::join(marks, ", ")));
  if (border) named.emplace_back("the border");
  if (layout) named.emplace_back("the marks' calibrated positions");
  return fmt::format("{}", fmt::join(named, " and "));
}

std::vector<OrientationEvidence> VoteNames::Evidence(const std::vector<OrientationVote>& votes,
                                                     const OrientationClass& open) const {
  std::vector<OrientationEvidence> evidence;
  if (open.size() < 2) return evidence;
  for (const OrientationVote& vote : votes) {
    const auto silent = [](double nats) { return nats == 0; };
    if (vote.layout && std::all_of(vote.nats.begin(), vote.nats.end(), silent)) continue;
    OrientationEvidence said{NameOf(vote), {}};
    for (size_t o = 0; o < open.size(); ++o) said.nats.emplace_back(open[o], vote.nats[o]);
    evidence.push_back(std::move(said));
  }
  return evidence;
}

std::string VoteNames::OffScan(const std::vector<OrientationVote>& votes) const {
  std::vector<std::string> names;
  for (const OrientationVote& vote : votes)
    if (vote.off_scan) names.push_back(NameOf(vote));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string VoteNames::MarkOf(const OrientationVote& vote) const {
  const size_t mark = relabel_ ? static_cast<size_t>((*relabel_)[*vote.mark]) : *vote.mark;
  return camera_.fiducials[mark].id;
}

std::string VoteNames::NameOf(const OrientationVote& vote) const {
  if (vote.mark) return SymbolOf(MarkOf(vote));
  if (vote.layout || !vote.feature) return kByMarkPositions;
  // The data strip follows the camera file's own features (BorderFeatures).
  if (*vote.feature >= camera_.border.size()) return "data strip";
  return fmt::format("border {}", *vote.feature + 1);
}

void RenameSymbols(const CameraFile& camera, const std::vector<int>& relabel,
                   std::vector<OrientationEvidence>* evidence) {
  for (OrientationEvidence& said : *evidence)
    for (size_t i = 0; i < relabel.size(); ++i)
      if (relabel[i] >= 0 && said.by == SymbolOf(camera.fiducials[i].id)) {
        said.by = SymbolOf(camera.fiducials[relabel[i]].id);
        break;
      }
}

}  // namespace orient::interior
