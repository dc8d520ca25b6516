// What an output folder says at the moment, for the page: read when its files have changed.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/measurements/measurements.h"
#include "tools/report/block_record.h"
#include "tools/report/verdict.h"

namespace orient {

struct ReviewState {
  BlockRecord block;
  BlockVerdict verdict;
  // By photo: digest of the measurements and decisions its results were made from (empty: none);
  // missing if there is no result that states it.
  std::map<std::string, std::string> interior_digests, exterior_digests;

  const PhotoRecord* Photo(const std::string& name) const;
};

// Safe from several threads.
class ReviewStates {
 public:
  explicit ReviewStates(std::string directory) : directory_(std::move(directory)) {}

  // Throws InputError where the folder holds no results.
  std::shared_ptr<const ReviewState> Now();

 private:
  std::string directory_;
  std::mutex mutex_;
  std::string files_;  // that state_ was read from: their names, sizes and times of change
  std::shared_ptr<const ReviewState> state_;
};

// Whether something was said of the photo since it was oriented.
bool IsPending(const ReviewState& state, const Measurements& measurements,
               const std::string& photo);

}  // namespace orient
