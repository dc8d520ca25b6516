#include "block/roll/roll_orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "interior/interior.h"
#include "interior/orientation/film_orientation.h"

namespace orient::block {
namespace {

using interior::kSureNats;

constexpr int kFewestPhotos = 3;            // with evidence for it
constexpr double kTelling = 1;              // nats between two orientations
constexpr double kMostContradicting = 0.1;  // of the photos with any evidence

using Nats = std::array<double, kAllScanOrientations.size()>;

// Photos vote with their own status: what the comparison with the roll made of it is no reason to
// vote otherwise when a run is resumed.
bool HasVote(const InteriorResult& photo) {
  return photo.status_alone.value_or(photo.status) == Status::kOk;
}

// Log-likelihood of each scan orientation relative to the photo's likeliest one.
Nats VotesOf(const InteriorResult& photo) {
  Nats nats;
  nats.fill(-kSureNats);
  const auto& possible = photo.possible_orientations;
  for (size_t i = 0; i < possible.size(); ++i) {
    const double vote = i < photo.orientation_nats.size() ? photo.orientation_nats[i] : 0;
    nats[static_cast<size_t>(possible[i])] = std::max(vote, -kSureNats);
  }
  return nats;
}

bool Leaves(const InteriorResult& photo, ScanOrientation orientation) {
  return VotesOf(photo)[static_cast<size_t>(orientation)] > -kSureNats;
}

// The part of a photo's votes due to its marks' positions; empty if they contribute none.
std::optional<Nats> VotesOfPositions(const InteriorResult& photo) {
  const auto by_positions =
      std::find_if(photo.orientation_evidence.begin(), photo.orientation_evidence.end(),
                   [](const OrientationEvidence& of) { return of.by == kByMarkPositions; });
  if (by_positions == photo.orientation_evidence.end() || by_positions->nats.empty())
    return std::nullopt;
  Nats nats;
  nats.fill(-kSureNats);
  double best = -std::numeric_limits<double>::infinity();
  for (const auto& [orientation, value] : by_positions->nats) best = std::max(best, value);
  for (const auto& [orientation, value] : by_positions->nats)
    nats[static_cast<size_t>(orientation)] = std::max(value - best, -kSureNats);
  return nats;
}

// The photos' votes are independent except those of the marks' positions: what scanner, film and
// camera file do to these is the same in every photo, so only their mean counts, once.
struct Sum {
  Nats nats{};
  std::vector<Nats> votes;  // of the photos that can be read

  explicit Sum(const std::vector<InteriorResult>& results) {
    Nats positions{};
    int with_positions = 0;
    for (const InteriorResult& result : results) {
      if (!HasVote(result) || result.possible_orientations.empty()) continue;
      votes.push_back(VotesOf(result));
      const auto of_positions = VotesOfPositions(result);
      for (size_t i = 0; i < nats.size(); ++i)
        nats[i] += std::min(votes.back()[i] - (of_positions ? (*of_positions)[i] : 0), 0.0);
      if (!of_positions) continue;
      for (size_t i = 0; i < nats.size(); ++i) positions[i] += (*of_positions)[i];
      ++with_positions;
    }
    for (size_t i = 0; i < nats.size() && with_positions > 0; ++i)
      nats[i] += positions[i] / with_positions;
  }

  // Number of photos with evidence for one orientation against another.
  std::ptrdiff_t Telling(size_t one, size_t other) const {
    return std::count_if(votes.begin(), votes.end(),
                         [&](const Nats& vote) { return vote[one] - vote[other] >= kTelling; });
  }

  // Number of photos with any evidence.
  std::ptrdiff_t Telling() const {
    return std::count_if(votes.begin(), votes.end(), [](const Nats& vote) {
      const auto [least, most] = std::minmax_element(vote.begin(), vote.end());
      return *most - *least >= kTelling;
    });
  }

  // Among equally likely ones the first: unmirrored, not rotated.
  size_t Likeliest() const {
    return static_cast<size_t>(std::max_element(nats.begin(), nats.end()) - nats.begin());
  }
};

void SetFinding(Reason reason, const std::vector<ScanOrientation>& open, InteriorResult* result) {
  std::vector<std::string_view> names;
  for (const ScanOrientation orientation : open) names.push_back(Name(orientation));
  const std::string where = fmt::format("{}", fmt::join(names, ", "));
  for (Finding& finding : result->findings)
    if (finding.reason == Reason::kOrientationOpen || finding.reason == Reason::kOrientationOfRoll)
      finding = {.reason = reason, .where = where};
}

// Leaves the orientations `open` with these nats; transform and names are of the first one. The
// result must have one of them now.
void Open(const CameraFile& camera, const interior::MarkShapes& shapes,
          std::vector<ScanOrientation> open, std::vector<double> nats, InteriorResult* result) {
  InteriorResult base = *result;
  base.possible_orientations.push_back(open.front());
  const auto turned = InOrientation(base, camera, shapes, open.front());
  if (!turned) return;
  *result = *turned;
  result->orientations_alone.clear();
  result->orientation.reset();
  SetFinding(Reason::kOrientationOpen, open, result);
  result->possible_orientations = std::move(open);
  result->orientation_nats = std::move(nats);
}

// Moves the orientation `first` to the front of the orientations and their nats.
void PutFirst(ScanOrientation first, std::vector<ScanOrientation>* ways,
              std::vector<double>* nats) {
  const auto at = std::find(ways->begin(), ways->end(), first) - ways->begin();
  std::rotate(ways->begin(), ways->begin() + at, ways->begin() + at + 1);
  if (nats->size() == ways->size())
    std::rotate(nats->begin(), nats->begin() + at, nats->begin() + at + 1);
}

void Decide(const CameraFile& camera, const interior::MarkShapes& shapes,
            ScanOrientation orientation, InteriorResult* result) {
  const auto turned = InOrientation(*result, camera, shapes, orientation);
  if (!turned) return;
  const std::vector<ScanOrientation> alone = result->possible_orientations;
  const std::vector<double> nats = result->orientation_nats;
  *result = *turned;
  result->orientations_alone = alone;
  result->orientation_nats = nats;
  SetFinding(Reason::kOrientationOfRoll, alone, result);
}

}  // namespace

std::optional<ScanOrientation> OrientationOfRoll(const std::vector<InteriorResult>& results) {
  const Sum sum(results);
  const size_t best = sum.Likeliest();
  for (size_t i = 0; i < sum.nats.size(); ++i)
    if (i != best &&
        (sum.nats[i] > sum.nats[best] - kSureNats || sum.Telling(best, i) < kFewestPhotos))
      return std::nullopt;
  const ScanOrientation orientation = kAllScanOrientations[best];
  const auto contradicting =
      std::count_if(results.begin(), results.end(), [&](const InteriorResult& result) {
        return HasVote(result) && !Leaves(result, orientation);
      });
  if (static_cast<double>(contradicting) > kMostContradicting * static_cast<double>(sum.Telling()))
    return std::nullopt;
  return orientation;
}

std::vector<size_t> OrientAsRoll(const CameraFile& camera, const interior::MarkShapes& shapes,
                                 bool alike, std::vector<InteriorResult>* results) {
  const std::vector<InteriorResult> before = *results;
  for (InteriorResult& result : *results)
    if (!result.orientations_alone.empty())
      Open(camera, shapes, result.orientations_alone, result.orientation_nats, &result);
  const auto decided = alike ? OrientationOfRoll(*results) : std::nullopt;
  const ScanOrientation likeliest = kAllScanOrientations[Sum(*results).Likeliest()];
  std::vector<size_t> changed;
  for (size_t i = 0; i < results->size(); ++i) {
    InteriorResult& result = (*results)[i];
    if (alike && result.possible_orientations.size() > 1 && Leaves(result, likeliest)) {
      if (decided) {
        Decide(camera, shapes, *decided, &result);
      } else if (result.possible_orientations.front() != likeliest) {
        auto ways = result.possible_orientations;
        auto nats = result.orientation_nats;
        PutFirst(likeliest, &ways, &nats);
        Open(camera, shapes, ways, nats, &result);
      }
    }
    if (result.possible_orientations != before[i].possible_orientations ||
        result.findings != before[i].findings)
      changed.push_back(i);
  }
  return changed;
}

}  // namespace orient::block
