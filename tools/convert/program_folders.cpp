#include "tools/convert/program_folders.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/files/orientation_table.h"

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

}  // namespace

void RequireDigitalImages(const std::vector<std::string>& images, const std::string& extension) {
  for (const std::string& image : images) {
    if (fs::path(image).extension() != extension)
      throw UsageError(
          fmt::format("{} does not end in {}, as the files written name it; give "
                      "--image-extension",
                      image, extension));
    if (!fs::exists(image))
      throw InputError(image + " is no file here that could be linked; copy it");
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
    if (WantsFolder(format)) Link("../images", folder / "images");
    if (!WantsImagesBeside(format)) continue;
    for (const ExchangePhoto& photo : block.photos)
      if (fs::exists(images / photo.image))
        Link(fs::path("../images") / photo.image, folder / photo.image);
  }
}

}  // namespace orient
