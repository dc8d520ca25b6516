// Why a result is what it is: reasons that programs can read, with their figures. A status is
// decided from them (interior/judge, exterior/judge, block/verdict/judge), sentences are made from
// them, and nothing ever reads a sentence.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/files/reason.h"

namespace orient {

enum class Status { kOk, kWeak, kFailed };
std::string_view Name(Status status);  // "ok", "weak", "failed"

struct Finding {
  Reason reason;
  Status at_best = Status::kOk;      // the best status that it allows
  std::optional<double> value = {};  // what was found,
  std::optional<double> limit = {};  // and what it is compared with
  std::string where = {};            // marks, photos, files: what the sentence names

  bool operator==(const Finding&) const = default;
};
using Findings = std::vector<Finding>;

// "marks_not_found": what result files and programs call it.
std::string_view Code(Reason reason);
std::optional<Reason> ReasonFromCode(std::string_view code);
// All reasons, in the order of the enum.
const std::vector<Reason>& AllReasons();

// In plain words, with the figures.
std::string Sentence(const Finding& finding);
std::vector<std::string> Sentences(const Findings& findings);
// "; " between them.
std::string JoinedSentences(const Findings& findings);

// The worst `at_best` of the findings; ok if there are none.
Status StatusOf(const Findings& findings);
bool Has(const Findings& findings, Reason reason);

}  // namespace orient
