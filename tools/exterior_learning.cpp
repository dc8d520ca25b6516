#include "tools/exterior_learning.h"

#include <filesystem>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "patchdb/older_file.h"
#include "tools/exposure_date.h"
#include "tools/made_from.h"
#include "tools/patchdb_to_write.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Before hours of work, not after the first photo.
template <typename Work>
auto Writing(const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) +
                     "; the patch database cannot be written: give --no-feedback, or a copy that "
                     "can");
  }
}

// One connection for the whole run.
std::optional<PatchDatabase> OpenForFeedback(const ExteriorRunOptions& options) {
  if (!options.feedback) return std::nullopt;
  return Writing([&] { return PatchDatabase::Open(options.patchdb, PatchDatabase::Mode::kWrite); });
}

// Returns why the database could not be told; empty: it was, or there was nothing to tell.
std::string Feedback(PatchDatabase& database, const std::string& path, CameraKind kind,
                     const ExteriorResult& result) {
  std::vector<MatchAttempt> attempts;
  for (const PatchResult& patch : result.patches)
    if (patch.state != PatchState::kNotVisible)
      attempts.push_back({patch.id, result.photo, std::string(Name(patch.state)), patch.ncc,
                          patch.residual_px, patch.reason, std::nullopt,
                          std::string(Name(result.status)), patch.predicted, patch.pixel, ""});
  if (attempts.empty()) return "";
  try {
    const std::string digest = DigestOfFile(path);
    const auto date = ExposureDate(path, kind);
    for (MatchAttempt& attempt : attempts) {
      attempt.photo_digest = digest;
      attempt.photo_date = date;
    }
    database.RecordAttempts(attempts);
  } catch (const InputError& error) {
    return std::string("the patch database did not learn from it: ") + error.what();
  }
  return "";
}

}  // namespace

void BringUpToDateForFeedback(const std::string& patchdb, std::ostream& out) {
  if (OlderVersion(patchdb)) Writing([&] { return OpenToWrite(patchdb, out); });
}

Learning::Learning(const ExteriorRunOptions& options)
    : options_(options),
      database_(OpenForFeedback(options)),
      note_((fs::path(options.out) / "not_yet_learnt").string()) {
  if (!database_) return;
  interrupted_ = options.resume && fs::exists(note_);
  WriteFileAtomically(note_, "the patch database has not learnt from these results yet\n");
}

void Learning::Tell(const std::vector<char>& fresh, CameraKind kind,
                    std::vector<ExteriorResult>* results) {
  if (!database_) return;
  for (std::size_t i = 0; i < results->size(); ++i) {
    if (!fresh[i] && !interrupted_) continue;
    const std::string why_not = Feedback(*database_, options_.photos[i], kind, (*results)[i]);
    if (why_not.empty()) continue;
    (*results)[i].messages.push_back(why_not);
    WriteExteriorResult(options_.out, (*results)[i]);
  }
  fs::remove(note_);
}

}  // namespace orient
