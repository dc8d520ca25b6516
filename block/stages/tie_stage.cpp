#include "block/stages/tie_stage.h"

#include <algorithm>
#include <new>
#include <optional>

#include "block/inputs/digest.h"
#include "block/stages/jobs.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"

namespace orient::block {
namespace {

// What the ties of one photo depend on; to be raised where the method changes.
constexpr const char* kMethod = "ties 2";

// `digests`: of all photos.
Inputs InputsOf(const TieStage& stage, std::size_t owner,
                const std::vector<std::size_t>& neighbours,
                const std::vector<std::string>& digests) {
  Inputs lent;
  for (const std::size_t i : neighbours) lent[stage.photos[i].name] = digests[i];
  Inputs inputs = stage.inputs;
  inputs["method"] = kMethod;
  inputs["photo"] = digests[owner];
  inputs["neighbours"] = DigestOf(lent);
  return inputs;
}

std::vector<TieRecord> Records(const std::vector<MeasuredTie>& ties,
                               const std::vector<TiePhoto>& photos) {
  std::vector<TieRecord> records;
  for (const MeasuredTie& tie : ties) {
    TieRecord record{tie.ground_m, {}};
    for (const TieSighting& seen : tie.seen)
      record.seen.push_back({photos[seen.photo].name, seen.pixel, seen.covariance_px2, seen.ncc});
    records.push_back(std::move(record));
  }
  return records;
}

// Photos keep the block's order, so that neighbours agree on who owns what.
std::vector<TieRecord> MeasureTies(const TieStage& stage, std::size_t owner,
                                   const std::vector<std::size_t>& neighbours) {
  if (neighbours.empty()) return {};
  std::vector<std::size_t> which = neighbours;
  which.push_back(owner);
  std::sort(which.begin(), which.end());
  const OpenPhotos open(stage.photos, which, owner, stage.camera);
  return Records(FindTies(open.Photos(), open.Owner(), stage.surface), open.Photos());
}

// `failure`: why the photo has no ties, which is no result.
Job JobOf(const TieStage& stage, std::size_t owner, const std::vector<std::string>& digests,
          std::optional<std::string>* failure) {
  const std::string& name = stage.photos[owner].name;
  const std::vector<std::size_t> neighbours = NeighboursOf(stage.photos, owner);
  const Inputs inputs = InputsOf(stage, owner, neighbours, digests);
  const auto run = [=, &stage, &name] {
    try {
      WriteTieFile(stage.store.PathOf(name), name, inputs, MeasureTies(stage, owner, neighbours));
    } catch (const InputError& error) {
      *failure = error.what();
    } catch (const std::exception& error) {
      RethrowIfMachineFault();
      *failure = std::string("internal error, please report it: ") + error.what();
    }
  };
  const auto keep = [=, &stage, &name] { ReadTieFile(stage.store.PathOf(name)); };
  return {name, inputs, run, keep};
}

}  // namespace

std::vector<TieRecord> RunTieStage(const TieStage& stage, const std::function<void()>& done,
                                   Findings* findings) {
  MakeOutputDirectory(stage.store.Folder());
  std::vector<std::string> digests(stage.photos.size());
  std::vector<std::optional<std::string>> failures(stage.photos.size());
  for (std::size_t i = 0; i < digests.size(); ++i)
    if (stage.photos[i].HasPose()) digests[i] = DigestOfPhoto(stage.photos[i]);
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < digests.size(); ++i)
    if (stage.photos[i].HasPose()) jobs.push_back(JobOf(stage, i, digests, &failures[i]));
  RunJobs(jobs, stage.store, {stage.jobs, true, false, done});
  std::vector<TieRecord> ties;
  for (std::size_t i = 0; i < digests.size(); ++i) {
    if (failures[i])
      findings->push_back({.reason = Reason::kNoTiesFromPhoto,
                           .where = stage.photos[i].name + ": " + *failures[i]});
    if (!stage.photos[i].HasPose() || failures[i]) continue;
    auto own = ReadTieFile(stage.store.PathOf(stage.photos[i].name));
    ties.insert(ties.end(), std::make_move_iterator(own.begin()),
                std::make_move_iterator(own.end()));
  }
  return ties;
}

}  // namespace orient::block
