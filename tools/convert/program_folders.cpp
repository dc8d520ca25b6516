#include "tools/convert/program_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/files/orientation_table.h"
#include "tools/convert/program_names.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

void Link(const fs::path& target, const fs::path& link) {
  std::error_code error;
  if (fs::is_symlink(link, error)) fs::remove(link, error);
  if (fs::exists(link, error))
    throw InputError(link.string() + " is in the way of a link to the image; remove it");
  fs::create_symlink(target, link, error);
  if (error)
    throw InputError(fmt::format("cannot link {} to {}: {}; copy the images there", link.string(),
                                 target.string(), error.message()));
}

bool WantsFolder(ExchangeFormat format) {
  return format == ExchangeFormat::kOpensfm || format == ExchangeFormat::kColmap;
}

bool WantsImagesBeside(ExchangeFormat format) {
  return format == ExchangeFormat::kMicmac || format == ExchangeFormat::kAsp;
}

bool AreTheImages(const std::vector<std::string>& names, const ExchangeBlock& block) {
  return std::equal(
      names.begin(), names.end(), block.photos.begin(), block.photos.end(),
      [](const std::string& name, const ExchangePhoto& photo) { return name == photo.image; });
}

// Removes a folder of links left by an earlier run; a folder with other files stays.
void RemoveFolderOfLinks(const fs::path& folder) {
  if (fs::is_symlink(folder) || !fs::is_directory(folder)) return;
  const bool links = std::all_of(fs::directory_iterator(folder), fs::directory_iterator(),
                                 [](const auto& entry) { return entry.is_symlink(); });
  if (links) fs::remove_all(folder);
}

// `from_folder`: the images' folder as seen from the links'.
void LinkEach(const fs::path& images, const fs::path& from_folder, const fs::path& folder,
              const std::vector<std::string>& names, const ExchangeBlock& block) {
  std::error_code error;
  if (fs::is_symlink(folder, error)) fs::remove(folder, error);
  MakeOutputDirectory(folder.string());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (fs::exists(images / block.photos[i].image))
      Link(from_folder / block.photos[i].image, folder / names[i]);
}

}  // namespace

void RequireDigitalImages(const std::vector<std::string>& images, const std::string& extension) {
  for (const std::string& image : images) {
    if (fs::path(image).extension() != extension)
      throw UsageError(
          fmt::format("{} does not end in {}, as the files written name it; give "
                      "--image-extension",
                      image, extension));
    if (!fs::exists(image))
      throw InputError(image + " is not a file on this machine that could be linked; copy it");
  }
}

void LinkDigitalImages(const std::string& out, const std::vector<std::string>& images,
                       const std::string& extension) {
  const fs::path folder = fs::path(out) / "images";
  MakeOutputDirectory(folder.string());
  for (const std::string& image : images)
    Link(fs::canonical(image), folder / (PhotoName(image) + extension));
}

void LinkImagesForPrograms(const std::string& out, const std::vector<ExchangeFormat>& formats,
                           const ExchangeBlock& block) {
  const fs::path images = fs::path(out) / "images";
  for (const ExchangeFormat format : formats) {
    const fs::path folder = fs::path(out) / Name(format);
    const std::vector<std::string> names = NamesInFiles(block, format);
    if (WantsFolder(format)) {
      RemoveFolderOfLinks(folder / "images");
      if (AreTheImages(names, block))
        Link("../images", folder / "images");
      else
        LinkEach(images, "../../images", folder / "images", names, block);
    }
    if (WantsImagesBeside(format)) LinkEach(images, "../images", folder, names, block);
  }
}

}  // namespace orient
