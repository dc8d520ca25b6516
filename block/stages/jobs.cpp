#include "block/stages/jobs.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <mutex>
#include <set>
#include <stdexcept>

#include "core/base/error.h"
#include "core/files/orientation_table.h"

namespace orient::block {
namespace {

void RequireOneResultEach(const std::vector<Job>& jobs) {
  std::set<std::string> names;
  for (const Job& job : jobs)
    if (!names.insert(job.name).second)
      throw std::invalid_argument("RunJobs: two jobs are named " + job.name);
}

bool MayBeKept(ResultState state, const JobRun& how) {
  return state == ResultState::kCurrent || (state == ResultState::kUnstated && how.keep_unstated);
}

// Keeps the existing result; false if it is damaged.
bool Keep(const Job& job) {
  try {
    if (job.keep) job.keep();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

KnownResult RunJob(const Job& job, const ResultStore& store, const JobRun& how,
                   std::exception_ptr* failure) {
  KnownResult known;
  try {
    known = store.Check(job.name, job.inputs);
    if (MayBeKept(known.state, how)) {
      known.state = Keep(job) ? ResultState::kCurrent : ResultState::kUnreadable;
      if (known.state == ResultState::kCurrent) return known;
    }
    store.Drop(job.name);
    job.run();
  } catch (...) {
    *failure = std::current_exception();
    store.Drop(job.name);  // it may have been written before
  }
  return known;
}

}  // namespace

void RequireOwnNames(const std::vector<std::string>& photos) {
  std::set<std::string> names;
  for (const std::string& photo : photos) {
    const std::string name = PhotoName(photo);
    if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }))
      throw UsageError("the name of the photo " + photo +
                       " holds a line break or another control character; rename it");
    if (!names.insert(name).second)
      throw UsageError("two photos are named " + name +
                       " and would write the same result; orient them in separate runs");
  }
}

std::vector<KnownResult> RunJobs(const std::vector<Job>& jobs, const ResultStore& store,
                                 const JobRun& how) {
  RequireOneResultEach(jobs);
  if (!how.keep)
    for (const Job& job : jobs) store.Drop(job.name);
  std::vector<KnownResult> known(jobs.size());
  std::vector<std::exception_ptr> failures(jobs.size());
  std::mutex mutex;
  tbb::task_arena arena(how.at_a_time > 0 ? how.at_a_time : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, jobs.size(),
        [&](std::size_t i) {
          known[i] = RunJob(jobs[i], store, how, &failures[i]);
          if (!how.done) return;
          const std::lock_guard<std::mutex> lock(mutex);
          how.done();
        },
        tbb::simple_partitioner());
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  return known;
}

}  // namespace orient::block
