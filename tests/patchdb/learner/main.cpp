// What `orient exterior` does at the end of every photo, again and again, to be killed by
// patchdb_kill_test.py: reports all patches as sought in a photo, then says so.
//
//   patchdb_learner DB FIRST COUNT    photos FIRST .. FIRST + COUNT - 1
#include <cstdlib>
#include <iostream>

#include "patchdb/store/patch_database.h"
#include "patchdb/store/selection.h"

int main(int argc, char** argv) {
  if (argc != 4) return 1;
  try {
    auto database =
        orient::patchdb::PatchDatabase::Open(argv[1], orient::patchdb::PatchDatabase::Mode::kWrite);
    const auto ids = orient::patchdb::ChooseIds(database, {});
    const int first = std::atoi(argv[2]);
    for (int photo = first; photo < first + std::atoi(argv[3]); ++photo) {
      std::vector<orient::patchdb::MatchAttempt> attempts;
      for (const std::int64_t id : ids) {
        orient::patchdb::MatchAttempt attempt;
        attempt.patch_id = id;
        attempt.photo = "learnt-" + std::to_string(photo);
        attempt.state = (id + photo) % 3 == 0 ? "not_found" : "matched";
        attempt.photo_status = "ok";
        attempts.push_back(attempt);
      }
      database.RecordAttempts(attempts);
      std::cout << attempts.front().photo << " " << attempts.size() << std::endl;
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
