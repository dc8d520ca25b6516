#include "tools/report/block_record.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_files.h"
#include "block/inputs/block_photos.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::string_view kInterior = ".interior.json";
constexpr std::string_view kExterior = ".exterior.json";
constexpr std::string_view kMarks = ".marks.png";
constexpr std::string_view kPatches = ".patches.png";

using Photos = std::map<std::string, PhotoRecord>;

// The photo's name where `file` is one of its results.
std::optional<std::string> PhotoOf(const std::string& file, std::string_view suffix) {
  if (!file.ends_with(suffix) || file.size() == suffix.size()) return std::nullopt;
  return file.substr(0, file.size() - suffix.size());
}

// Reads one result of `photo` by `read`; errors in the file are the photo's problem alone.
template <typename Result>
void ReadInto(Result (*read)(const std::string&), const std::string& path, PhotoRecord* photo,
              std::optional<Result>* target) {
  try {
    *target = read(path);
  } catch (const InputError& error) {
    photo->unreadable.push_back(error.what());
  }
}

void AddFile(const fs::path& path, Photos* photos) {
  const std::string file = path.filename().string();
  const auto record = [&](const std::string& name) {
    PhotoRecord& photo = (*photos)[name];
    photo.name = name;
    return &photo;
  };
  if (const auto name = PhotoOf(file, kInterior)) {
    PhotoRecord* photo = record(*name);
    ReadInto(&ReadInteriorResult, path.string(), photo, &photo->interior);
  } else if (const auto name2 = PhotoOf(file, kExterior)) {
    PhotoRecord* photo = record(*name2);
    ReadInto(&ReadExteriorResult, path.string(), photo, &photo->exterior);
  }
}

// Pictures belong to photos that have a result; others are of no use here.
void AddPictures(const std::string& directory, PhotoRecord* photo) {
  const auto existing = [&](std::string_view suffix) {
    const std::string file = photo->name + std::string(suffix);
    return fs::is_regular_file(fs::path(directory) / file) ? file : std::string();
  };
  photo->marks_picture = existing(kMarks);
  photo->patches_picture = existing(kPatches);
  photo->marks_overview = existing(block::kMarksOverview);
  photo->patches_overview = existing(block::kPatchesOverview);
  photo->thumbnail = existing(block::kThumbnail);
}

void AddTable(const std::string& directory, Photos* photos, BlockRecord* block) {
  const fs::path csv = fs::path(directory) / "orientation.csv";
  const fs::path prj = fs::path(directory) / "orientation.prj";
  try {
    if (fs::exists(prj)) block->crs = Crs::FromFile(prj.string());
    if (!fs::exists(csv)) return;
    for (OrientationRow& row : ReadOrientationTable(csv.string()).rows) {
      PhotoRecord& photo = (*photos)[row.photo];
      photo.name = row.photo;
      photo.table_row = std::move(row);
    }
  } catch (const InputError& error) {
    block->unreadable.push_back(error.what());
  }
}

void AddCamera(const std::string& directory, BlockRecord* block) {
  const std::string path = block::BlockCameraPath(directory);
  try {
    if (fs::exists(path)) block->camera = ReadCameraFile(path).camera;
  } catch (const InputError& error) {
    block->unreadable.push_back(error.what());
  }
}

void AddQuicklook(const std::string& directory, BlockRecord* block) {
  const auto existing = [&](const char* file) {
    return fs::is_regular_file(fs::path(directory) / file) ? file : "";
  };
  block->quicklook_picture = existing(block::kQuicklookFile);
  block->seams_picture = existing(block::kSeamsFile);
}

// Adds the record of the run that made them last; each orthophoto states its own pose.
void AddOrthophotos(const std::string& directory, const Photos& photos, BlockRecord* block) {
  block->ortho = ReadOrthoFolder(directory);
  if (!block->ortho) return;
  const auto runs = ReadRunRecords((fs::path(directory) / block->ortho->folder).string());
  if (const auto run = runs.find("ortho"); run != runs.end()) block->runs["ortho"] = run->second;
  const bool any_poses = std::any_of(photos.begin(), photos.end(),
                                     [](const auto& photo) { return photo.second.table_row; });
  if (!any_poses) return;
  for (const OrthoFigures& ortho : block->ortho->photos) {
    if (!ortho.pose) continue;
    const auto now = photos.find(ortho.photo);
    if (now == photos.end() || !now->second.table_row)
      block->ortho->without_pose.push_back(ortho.photo);
    else if (!block::SamePose(*ortho.pose, now->second.table_row->pose))
      block->ortho->of_other_poses.push_back(ortho.photo);
  }
}

void AddAdjustment(const std::string& directory, BlockRecord* block) {
  const std::string path = AdjustmentResultPath(directory);
  try {
    if (fs::exists(path)) block->adjusted = ReadAdjustmentResult(path);
  } catch (const InputError& error) {
    block->unreadable.push_back(error.what());
  }
}

// "survey/out" -> "survey / out": the last folder alone is often just "out".
std::string TitleOf(const std::string& directory) {
  std::error_code ignored;  // the title then comes from the path as it was given
  fs::path path = fs::weakly_canonical(directory, ignored);
  if (ignored) path = directory;
  if (path.filename().empty()) path = path.parent_path();
  const std::string parent = path.parent_path().filename().string();
  return (parent.empty() ? "" : parent + " / ") + path.filename().string();
}

}  // namespace

bool BlockRecord::HasExterior() const {
  return std::any_of(photos.begin(), photos.end(),
                     [](const PhotoRecord& photo) { return photo.exterior.has_value(); });
}

BlockRecord ReadBlockRecord(const std::string& directory,
                            std::optional<AdjustmentResult> adjusted) {
  if (!fs::is_directory(directory))
    throw InputError(directory + " is not a folder; give the --out folder of orient block");
  BlockRecord block;
  block.directory = directory;
  block.title = TitleOf(directory);
  Photos photos;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory))
    if (entry.is_regular_file()) AddFile(entry.path(), &photos);
  AddTable(directory, &photos, &block);
  if (adjusted)
    block.adjusted = std::move(adjusted);
  else
    AddAdjustment(directory, &block);
  if (block.adjusted) block.notes = Sentences(block.adjusted->findings);
  AddCamera(directory, &block);
  AddQuicklook(directory, &block);
  block.runs = ReadRunRecords(directory);
  AddOrthophotos(directory, photos, &block);
  if (photos.empty())
    throw InputError(directory +
                     ": the folder holds no results (<photo>.interior.json, "
                     "<photo>.exterior.json); give the --out folder of orient block");
  for (auto& [name, photo] : photos) {
    if (photo.table_row && photo.exterior)
      if (std::string why = block::PoseContradiction(*photo.table_row, *photo.exterior);
          !why.empty())
        photo.unreadable.push_back(std::move(why));
    AddPictures(directory, &photo);
    block.photos.push_back(std::move(photo));
  }
  return block;
}

std::vector<ExteriorResult> TakeExteriorResults(BlockRecord* block) {
  std::vector<ExteriorResult> results;
  for (PhotoRecord& photo : block->photos) {
    if (photo.exterior) results.push_back(std::move(*photo.exterior));
    photo.exterior.reset();
  }
  return results;
}

}  // namespace orient
