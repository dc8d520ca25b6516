// Attempts taken into the database, with what follows from them. Private to patchdb.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "patchdb/store/connection.h"
#include "patchdb/store/learning.h"
#include "patchdb/store/match_attempt.h"

namespace orient::patchdb {

// Stores the attempts with how their neighbours fared, and learns from all patches that they name.
// Patches that are not there are left out, and attempts of which the database has another patch of
// that number by now; returns how many of these. `elsewhere`: further neighbours. The caller holds
// the transaction.
int Learn(Connection& connection, const std::vector<MatchAttempt>& attempts,
          const std::vector<SoughtElsewhere>& elsewhere = {});

// Ground position of the patch searched for: from the attempt, else from the database. Empty if
// neither has one.
std::optional<Eigen::Vector2d> PlaceSought(Connection& connection, const MatchAttempt& attempt);

// Weighs a patch's attempts anew; with `may_retire` it is retired where they say so.
void LearnAnew(Connection& connection, std::int64_t patch_id, bool may_retire);

// What a patch's attempts say.
SuccessWeights WeightsOf(Connection& connection, std::int64_t patch_id);

}  // namespace orient::patchdb
