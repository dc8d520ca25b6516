#include "patchdb/store/learn.h"

#include <algorithm>
#include <set>

#include "patchdb/store/learning.h"
#include "patchdb/store/patch_rows.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

constexpr std::size_t kNeighbours = 8;  // the nearest that were searched for in the same photo

struct SoughtPatch {
  std::optional<std::size_t> attempt;  // empty: of another database
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  bool matched = false;
};

struct NeighbourCount {
  int sought = 0, matched = 0;
};

NeighbourCount CountNeighbours(const std::vector<SoughtPatch>& sought, const SoughtPatch& centre) {
  std::vector<std::pair<double, bool>> others;  // squared distance, matched
  others.reserve(sought.size());
  for (const SoughtPatch& other : sought)
    if (other.attempt != centre.attempt)
      others.emplace_back((other.place_m - centre.place_m).squaredNorm(), other.matched);
  const std::size_t count = std::min(kNeighbours, others.size());
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count),
                    others.end());
  NeighbourCount neighbours{static_cast<int>(count), 0};
  for (std::size_t i = 0; i < count; ++i) neighbours.matched += others[i].second ? 1 : 0;
  return neighbours;
}

// Empty where there is no such patch, or it has no place.
std::optional<Eigen::Vector2d> PlaceOf(Connection& connection, std::int64_t patch_id) {
  const Query row = connection.Prepare(sql::kPlaceOf);
  row->bind(1, patch_id);
  if (!row->executeStep()) return std::nullopt;
  return Eigen::Vector2d(row->getColumn(0).getDouble(), row->getColumn(1).getDouble());
}

// Per attempt; empty where the patch was not searched for or has no place.
std::vector<std::optional<NeighbourCount>> Neighbours(
    Connection& connection, const std::vector<MatchAttempt>& attempts,
    const std::vector<SoughtElsewhere>& elsewhere) {
  std::map<std::string, std::vector<SoughtPatch>> photos;
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    if (attempts[i].state == "not_visible") continue;
    if (const auto place = PlaceSought(connection, attempts[i]))
      photos[attempts[i].photo].push_back({i, *place, attempts[i].state == "matched"});
  }
  for (const SoughtElsewhere& patch : elsewhere)
    photos[patch.photo].push_back({std::nullopt, patch.place_m, patch.matched});
  std::vector<std::optional<NeighbourCount>> counts(attempts.size());
  for (const auto& [photo, sought] : photos)
    for (const SoughtPatch& patch : sought)
      if (patch.attempt) counts[*patch.attempt] = CountNeighbours(sought, patch);
  return counts;
}

std::vector<AttemptOutcome> OutcomesOf(Connection& connection, std::int64_t patch_id) {
  const Query rows = connection.Prepare(sql::kAttemptsOf);
  rows->bind(1, patch_id);
  const auto text = [&](int i) -> std::optional<std::string> {
    if (rows->getColumn(i).isNull()) return std::nullopt;
    return rows->getColumn(i).getString();
  };
  const auto number = [&](int i) -> std::optional<int> {
    if (rows->getColumn(i).isNull()) return std::nullopt;
    return rows->getColumn(i).getInt();
  };
  std::vector<AttemptOutcome> outcomes;
  while (rows->executeStep())
    outcomes.push_back({rows->getColumn(0).getString(), text(1), text(2),
                        rows->getColumn(3).getInt(), number(4), number(5)});
  return outcomes;
}

std::optional<int> EpochOf(Connection& connection, std::int64_t patch_id) {
  const Query row = connection.Prepare(sql::kEpochOf);
  row->bind(1, patch_id);
  if (!row->executeStep()) return std::nullopt;
  return row->getColumn(0).getInt();
}

// Retires a patch but keeps the content token (content_digest.h): photos need not be oriented again
// because of what was learnt from them.
void RetireQuietly(Connection& connection, std::int64_t patch_id, const std::string& reason) {
  const Query known = connection.Prepare(sql::kContentToken);
  const std::string token = known->executeStep() ? known->getColumn(0).getString() : "";
  known->reset();
  const Query retire = connection.Prepare(sql::kRetire);
  retire->bind(1, patch_id);
  retire->bind(2, reason);
  retire->exec();
  const Query keep = connection.Prepare(sql::kSetContentToken);
  keep->bind(1, token.data(), static_cast<int>(token.size()));
  keep->exec();
}

// Whether the database was recreated meanwhile and its patch with that id is another one. The
// spatial index holds single-precision numbers.
bool IsOfAnother(Connection& connection, const MatchAttempt& attempt) {
  constexpr double kSame_m = 1, kRounding = 2.5e-7;
  if (!attempt.place_m) return false;
  const auto place_m = PlaceOf(connection, attempt.patch_id);
  return place_m && (*place_m - *attempt.place_m).cwiseAbs().maxCoeff() >
                        kSame_m + kRounding * place_m->cwiseAbs().maxCoeff();
}

}  // namespace

SuccessWeights WeightsOf(Connection& connection, std::int64_t patch_id) {
  return WeighAttempts(OutcomesOf(connection, patch_id), EpochOf(connection, patch_id).value_or(1));
}

void LearnAnew(Connection& connection, std::int64_t patch_id, bool may_retire) {
  const auto found = EpochOf(connection, patch_id);
  if (!found) return;
  const int epoch = *found;
  const auto outcomes = OutcomesOf(connection, patch_id);
  const SuccessWeights weights = WeighAttempts(outcomes, epoch);
  const Query update = connection.Prepare(sql::kSetWeights);
  update->bind(1, patch_id);
  update->bind(2, weights.success);
  update->bind(3, weights.failure);
  update->exec();
  const auto reason = may_retire ? WhyRetire(outcomes, epoch) : std::nullopt;
  if (!reason) return;
  RetireQuietly(connection, patch_id, *reason);
}

std::optional<Eigen::Vector2d> PlaceSought(Connection& connection, const MatchAttempt& attempt) {
  return attempt.place_m ? attempt.place_m : PlaceOf(connection, attempt.patch_id);
}

int Learn(Connection& connection, const std::vector<MatchAttempt>& attempts,
          const std::vector<SoughtElsewhere>& elsewhere) {
  int of_others = 0;
  const auto neighbours = Neighbours(connection, attempts, elsewhere);
  std::set<std::int64_t> patches;
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    const MatchAttempt& attempt = attempts[i];
    // Orienting a photo may take hours: the patch may have been pruned meanwhile.
    if (!EpochOf(connection, attempt.patch_id)) continue;
    if (IsOfAnother(connection, attempt)) {
      ++of_others;
      continue;
    }
    const Query forget = connection.Prepare(sql::kForgetUnknownPhoto);
    forget->bind(1, attempt.patch_id);
    forget->bind(2, attempt.photo);
    forget->exec();
    const Query insert = connection.Prepare(sql::kRecordAttempt);
    BindAttempt(attempt, *insert);
    if (neighbours[i]) {
      insert->bind(15, neighbours[i]->sought);
      insert->bind(16, neighbours[i]->matched);
    }
    insert->exec();
    patches.insert(attempt.patch_id);
  }
  for (const std::int64_t patch : patches) LearnAnew(connection, patch, true);
  return of_others;
}

}  // namespace orient::patchdb
