#include "block/stages/exterior_learning.h"

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

// Returns why the database could not be told; empty: it was, or there was nothing to tell.
std::string Feedback(patchdb::ControlPatches& database, const std::string& path,
                     const std::optional<std::string>& date, const ExteriorResult& result) {
  std::vector<patchdb::MatchAttempt> attempts;
  for (const PatchResult& patch : result.patches)
    if (patch.state != PatchState::kNotVisible)
      attempts.push_back({patch.id, result.photo, std::string(Name(patch.state)), patch.ncc,
                          patch.residual_px, JoinedSentences(patch.findings), std::nullopt,
                          std::string(Name(result.status)), patch.predicted, patch.pixel, ""});
  if (attempts.empty()) return "";
  try {
    const std::string digest = DigestOfFile(path);
    for (patchdb::MatchAttempt& attempt : attempts) {
      attempt.photo_digest = digest;
      attempt.photo_date = date;
    }
    database.RecordAttempts(attempts);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

void LeaveToLearn(const std::string& directory) {
  if (fs::exists(NotePath(directory))) return;
  WriteFileAtomically(NotePath(directory),
                      "the patch database has not learnt from these results yet\n");
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
  bool all_told = true;
  for (std::size_t i = 0; i < results->size(); ++i) {
    if (!fresh[i] && !interrupted_) continue;
    ExteriorResult& result = (*results)[i];
    const bool was_not_learnt = std::erase_if(result.findings, [](const Finding& finding) {
                                  return finding.reason == Reason::kNotLearnt;
                                }) > 0;
    const std::string why_not = Feedback(database_, photos[i], dates[i], result);
    if (!why_not.empty()) {
      result.findings.push_back({.reason = Reason::kNotLearnt, .where = why_not});
      all_told = false;
    }
    if (!why_not.empty() || was_not_learnt) WriteExteriorResult(directory_, result);
  }
  if (all_told) fs::remove(note_);
}

}  // namespace orient::block
