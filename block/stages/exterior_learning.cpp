#include "block/stages/exterior_learning.h"

#include <fmt/format.h>

#include <filesystem>

#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

std::string NotePath(const std::string& directory) {
  return (fs::path(directory) / "not_yet_learnt").string();
}

patchdb::ControlPatches OpenToLearn(const std::string& path) {
  try {
    return patchdb::ControlPatches::Open(path, patchdb::ControlPatches::Mode::kWrite);
  } catch (const InputError& error) {
    throw InputError(
        std::string(error.what()) +
        "; the patch database cannot be written: leave out --learn, or give a writable copy");
  }
}

std::vector<patchdb::MatchAttempt> AttemptsOf(const std::string& path,
                                              const std::optional<std::string>& date,
                                              const ExteriorResult& result) {
  std::vector<patchdb::MatchAttempt> attempts;
  for (const PatchResult& patch : result.patches)
    if (patch.state != PatchState::kNotVisible) {
      attempts.push_back({patch.id, result.photo, std::string(Name(patch.state)), patch.ncc,
                          patch.residual_px, JoinedSentences(patch.findings), date,
                          std::string(Name(result.status)), patch.predicted, patch.pixel, ""});
      if (patch.ground_m) attempts.back().place_m = patch.ground_m->head<2>();
    }
  if (attempts.empty()) return attempts;
  const std::string digest = DigestOfFile(path);
  for (patchdb::MatchAttempt& attempt : attempts) attempt.photo_digest = digest;
  return attempts;
}

// Which of a photo's attempts were not recorded in the database.
struct NotTold {
  std::string why;      // reason if none was recorded, else empty
  std::string but_for;  // attempts not recorded; empty: none
};

NotTold TellDatabase(const std::vector<patchdb::MatchAttempt>& attempts,
                     patchdb::ControlPatches& database) {
  try {
    const int of_others = database.RecordAttempts(attempts);
    if (of_others == 0) return {};
    return {"", fmt::format("{} of {}: these numbers now denote other patches", of_others,
                            attempts.size())};
  } catch (const InputError& error) {
    return {error.what(), ""};
  }
}

}  // namespace

void LeaveToLearn(const std::string& directory) {
  if (fs::exists(NotePath(directory))) return;
  WriteFileAtomically(NotePath(directory),
                      "these results are not yet recorded in the patch database\n");
}

Learning::Learning(const std::string& patchdb, const std::string& directory, bool resume)
    : directory_(directory),
      database_(OpenToLearn(patchdb)),
      note_(NotePath(directory)),
      interrupted_(resume && fs::exists(note_)) {
  LeaveToLearn(directory);
}

void Learning::Tell(const std::vector<std::string>& photos,
                    const std::vector<std::optional<std::string>>& dates,
                    const std::vector<char>& fresh, std::vector<ExteriorResult>* results) {
  // A database locked by another program delays every access: one attempt is enough.
  std::string why_not;
  for (std::size_t i = 0; i < results->size(); ++i) {
    if (!fresh[i] && !interrupted_) continue;
    ExteriorResult& result = (*results)[i];
    const auto attempts = AttemptsOf(photos[i], dates[i], result);
    if (attempts.empty()) continue;
    NotTold not_told{why_not, ""};
    if (why_not.empty()) not_told = TellDatabase(attempts, database_);
    why_not = not_told.why;
    const std::string& left = why_not.empty() ? not_told.but_for : why_not;
    const auto before = std::erase_if(
        result.findings, [](const Finding& f) { return f.reason == Reason::kNotLearnt; });
    if (!left.empty()) result.findings.push_back({.reason = Reason::kNotLearnt, .where = left});
    if (!left.empty() || before > 0) WriteExteriorResult(directory_, result);
  }
  if (why_not.empty()) fs::remove(note_);
}

}  // namespace orient::block
