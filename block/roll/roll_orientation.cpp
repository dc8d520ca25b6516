#include "block/roll/roll_orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "interior/interior.h"
#include "interior/orientation/film_orientation.h"

namespace orient::block {
namespace {

using interior::kSureNats;

constexpr int kFewestPhotos = 3;
constexpr double kMostContradicting = 0.1;  // of the photos

using Nats = std::array<double, kAllScanOrientations.size()>;

// Of each scan orientation less those of the photo's likeliest one.
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

struct Sum {
  Nats nats{};
  int photos = 0;

  explicit Sum(const std::vector<InteriorResult>& results) {
    for (const InteriorResult& result : results) {
      if (result.status != Status::kOk || result.possible_orientations.empty()) continue;
      const Nats votes = VotesOf(result);
      for (size_t i = 0; i < nats.size(); ++i) nats[i] += votes[i];
      ++photos;
    }
  }

  // Of equal ones the first: unmirrored, unturned.
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

// `open` ways with these nats; transform and names are those of the first one, of which the result
// must have one of them now.
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

// The ways in the order in which that one comes first.
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
  if (sum.photos < kFewestPhotos) return std::nullopt;
  const size_t best = sum.Likeliest();
  for (size_t i = 0; i < sum.nats.size(); ++i)
    if (i != best && sum.nats[i] > sum.nats[best] - kSureNats) return std::nullopt;
  const ScanOrientation orientation = kAllScanOrientations[best];
  const auto contradicting =
      std::count_if(results.begin(), results.end(), [&](const InteriorResult& result) {
        return result.status == Status::kOk && !Leaves(result, orientation);
      });
  if (static_cast<double>(contradicting) > kMostContradicting * sum.photos) return std::nullopt;
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
