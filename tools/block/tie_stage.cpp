#include "tools/block/tie_stage.h"

#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <new>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "tools/made_from.h"
#include "tools/shared_options.h"

namespace orient {
namespace {

// What the ties of one photo depend on; to be raised where the method changes.
constexpr const char* kMethod = "ties 2";

std::string DigestOfJob(const TieStage& stage, std::size_t owner,
                        const std::vector<std::size_t>& neighbours) {
  std::string text = kMethod + stage.inputs;
  const auto add = [&](std::size_t i) {
    const BlockPhotoFile& photo = stage.photos[i];
    text += photo.name + DigestOfFile(photo.path) + photo.made_from +
            Digest(ReadFile(photo.result_path));
  };
  add(owner);
  for (const std::size_t i : neighbours) add(i);
  return Digest(text);
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
void MeasureTies(const TieStage& stage, std::size_t owner,
                 const std::vector<std::size_t>& neighbours) {
  std::vector<std::size_t> which = neighbours;
  which.push_back(owner);
  std::sort(which.begin(), which.end());
  const OpenPhotos open(stage.photos, which, owner, stage.camera);
  const auto ties = FindTies(open.Photos(), open.Owner(), stage.surface);
  WriteTieFile(stage.folder.ResultPath(stage.photos[owner].name), stage.photos[owner].name,
               Records(ties, open.Photos()));
}

// Empty, or why the photo has no ties.
std::string RunJob(const TieStage& stage, std::size_t owner) {
  const std::string& name = stage.photos[owner].name;
  const std::vector<std::size_t> neighbours = NeighboursOf(stage.photos, owner);
  const std::string digest = DigestOfJob(stage, owner, neighbours);
  if (stage.folder.IsCurrent(name, digest)) return "";
  stage.folder.Drop(name);
  try {
    if (neighbours.empty())
      WriteTieFile(stage.folder.ResultPath(name), name, {});
    else
      MeasureTies(stage, owner, neighbours);
  } catch (const InputError& error) {
    return name + " gives no tie points: " + error.what();
  } catch (const std::bad_alloc&) {
    return name + " gives no tie points: out of memory; use fewer --jobs";
  } catch (const std::exception& error) {
    return name + " gives no tie points: internal error, please report it: " + error.what();
  }
  stage.folder.Note(name, digest);
  return "";
}

}  // namespace

std::vector<TieRecord> RunTieStage(const TieStage& stage, const std::function<void()>& done,
                                   std::vector<std::string>* messages) {
  MakeOutputDirectory(stage.folder.Directory());
  std::vector<std::size_t> owners;
  for (std::size_t i = 0; i < stage.photos.size(); ++i)
    if (stage.photos[i].HasPose()) owners.push_back(i);
  std::vector<std::string> failures(stage.photos.size());
  tbb::task_arena arena(stage.jobs > 0 ? stage.jobs : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for_each(owners, [&](std::size_t i) {
      failures[i] = RunJob(stage, i);
      if (done) done();
    });
  });
  std::vector<TieRecord> ties;
  for (const std::size_t i : owners) {
    if (!failures[i].empty()) {
      messages->push_back(failures[i]);
      continue;
    }
    auto own = ReadTieFile(stage.folder.ResultPath(stage.photos[i].name));
    ties.insert(ties.end(), std::make_move_iterator(own.begin()),
                std::make_move_iterator(own.end()));
  }
  return ties;
}

}  // namespace orient
