// A stage is a list of jobs: each with named inputs, one result, and no view of the others.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "block/stages/result_store.h"

namespace orient::block {

struct Job {
  std::string name;  // of its result in the store
  Inputs inputs;
  // Writes the result, which says that it was made from `inputs`, when all else is done. Whatever
  // it throws, there is no result. It may leave none without throwing, too: it is done again by the
  // next run.
  std::function<void()> run;
  // Reads the result that is kept. An InputError says that it is damaged: the job is run.
  std::function<void()> keep = {};
};

struct JobRun {
  int at_a_time = 0;  // jobs; 0: one per core
  bool keep = true;   // results that are current; otherwise all are dropped before the first job
  bool keep_unstated = false;       // those that do not say what they were made from, too
  std::function<void()> done = {};  // after each job, a kept one too; one call at a time, no throw
};

// For stages with a job per photo. Throws UsageError where two photos (paths) share a name: they
// would write the same result. Names with control characters have no place in tables.
void RequireOwnNames(const std::vector<std::string>& photos);

// Keeps the results that are current; drops the others, runs their jobs side by side and ends when
// all have ended. An exception in one job does not affect the results of others; of several that
// throw, the first in the order of `jobs` is rethrown at the end. A killed run leaves nothing but
// results that are whole: another run goes on from there.
// Returns what was known of each job's result before: of what is kCurrent the result is the old
// one, kept. Throws std::invalid_argument where two jobs have one name.
std::vector<KnownResult> RunJobs(const std::vector<Job>& jobs, const ResultStore& store,
                                 const JobRun& how = {});

}  // namespace orient::block
