#include "tools/convert/program_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "core/base/column_names.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

bool IsBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

std::string WithoutEnding(const std::string& image) {
  return (fs::path(image).parent_path() / BareImageName(image)).string();
}

bool CutsNames(ExchangeFormat format) {
  return format == ExchangeFormat::kColmap || format == ExchangeFormat::kAsp;
}

// Also makes the name different from all of `taken`, which have no endings.
std::string WithoutBlanks(std::string image, const std::set<std::string>& taken) {
  std::replace_if(image.begin(), image.end(), IsBlank, '_');
  const std::string name = WithoutEnding(image);
  const bool ends = BareImageName(image) != fs::path(image).filename().string();
  const std::string ending = ends ? fs::path(image).extension().string() : "";
  for (int number = 2; taken.contains(WithoutEnding(image)); ++number)
    image = fmt::format("{}_{}{}", name, number, ending);
  return image;
}

}  // namespace

std::vector<std::string> NamesInFiles(const ExchangeBlock& block, ExchangeFormat format) {
  std::vector<std::string> names;
  for (const ExchangePhoto& photo : block.photos) names.push_back(photo.image);
  if (!CutsNames(format)) return names;
  std::set<std::string> taken;
  const auto holds_blanks = [](const std::string& name) {
    return std::any_of(name.begin(), name.end(), IsBlank);
  };
  for (const std::string& name : names)
    if (!holds_blanks(name)) taken.insert(WithoutEnding(name));
  for (std::string& name : names) {
    if (!holds_blanks(name)) continue;
    name = WithoutBlanks(name, taken);
    taken.insert(WithoutEnding(name));
  }
  return names;
}

void RestoreNames(const std::map<std::string, std::string>& true_names, ExchangeBlock* block) {
  for (ExchangePhoto& photo : block->photos)
    for (const auto& [in_file, name] : true_names) {
      if (photo.image == in_file)
        photo.image = name;
      else if (photo.image == WithoutEnding(in_file))
        photo.image = WithoutEnding(name);
      else if (photo.image == BareImageName(in_file))  // the format has no folders
        photo.image = WithoutEnding(name);
      else
        continue;
      break;
    }
}

}  // namespace orient
