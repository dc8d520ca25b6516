// orient patchdb show: a contact sheet, chips with their numbers.

#include <CLI/CLI.hpp>
#include <ostream>

#include "core/base/error.h"
#include "core/raster/picture_text.h"
#include "core/raster/raster.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/spare_databases.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {

constexpr int kTile = 122;  // px a chip is drawn in
constexpr int kText = 16;   // below it
constexpr int kGap = 4;
constexpr int kCellWidth = kTile + 2 * kGap, kCellHeight = kTile + kText + 2 * kGap;
constexpr std::array<unsigned char, 3> kActive{20, 90, 40}, kRetired{180, 40, 30};

class ChipSheet {
 public:
  explicit ChipSheet(int count)
      : columns_(std::min(count, std::max(8, static_cast<int>(std::ceil(std::sqrt(count)))))),
        width_(columns_ * kCellWidth),
        height_((count + columns_ - 1) / columns_ * kCellHeight),
        rgb_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3, 255) {}

  void Add(const patchdb::Patch& patch) {
    const int col = next_ % columns_ * kCellWidth + kGap;
    const int row = next_ / columns_ * kCellHeight + kGap;
    ++next_;
    Draw(patch, col, row);
    const bool active = patch.life == patchdb::PatchLife::kActive;
    std::string text = std::to_string(patch.id);
    if (!active) text += " retired";
    DrawText(text, col, row + kTile + kText - 3, 9, active ? kActive : kRetired, width_, &rgb_);
  }
  void Write(const std::string& path) const { WritePng(path, width_, height_, 3, rgb_); }

 private:
  // Stretches the grey range of the chip to black and white; nearest pixel; no data stays white.
  void Draw(const patchdb::Patch& patch, int left, int top) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const float value : patch.chip.values) {
      low = std::fmin(low, value);
      high = std::fmax(high, value);
    }
    const float scale = high > low ? 255.0f / (high - low) : 0.0f;
    const double step = std::max(patch.chip.width, patch.chip.height) / static_cast<double>(kTile);
    for (int row = 0; row < static_cast<int>(patch.chip.height / step); ++row)
      for (int col = 0; col < static_cast<int>(patch.chip.width / step); ++col)
        for (std::size_t band = 0; band < 3; ++band) {
          const Image& image = patch.colour.empty() ? patch.chip : patch.colour[band];
          const float value = image.At(static_cast<int>(col * step), static_cast<int>(row * step));
          if (std::isnan(value)) continue;
          rgb_[(static_cast<std::size_t>(top + row) * static_cast<std::size_t>(width_) +
                static_cast<std::size_t>(left + col)) *
                   3 +
               band] = static_cast<unsigned char>(std::clamp((value - low) * scale, 0.0f, 255.0f));
        }
  }
  int columns_, width_, height_, next_ = 0;
  std::vector<unsigned char> rgb_;
};

class ShowVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("show", "Draw chips with their numbers in one image");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("--out", picture_, "PNG to write")->required();
    verb->add_flag("--overwrite", overwrite_, "Replace the picture if it exists");
    verb->add_option("--max", max_, "At most this many chips, evenly from all that are chosen")
        ->check(CLI::Range(1, 10000));
    choice_.DeclarePlace(*verb);
    choice_.DeclareRules(*verb);
    choice_.DeclareState(*verb);
    return verb;
  }
  void Run(std::ostream& out) override {
    RefuseToReplaceDatabase({picture_});
    RefuseToOverwrite({picture_}, overwrite_);
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    const auto ids = patchdb::ChooseIds(database, choice_.Filter(database));
    if (ids.empty()) throw InputError(path_ + " has no such patches; nothing to show");
    const std::size_t count = std::min(ids.size(), static_cast<std::size_t>(max_));
    ChipSheet sheet(static_cast<int>(count));
    for (std::size_t i = 0; i < count; ++i)
      if (const auto patch = database.ReadPatch(ids[i * ids.size() / count])) sheet.Add(*patch);
    sheet.Write(picture_);
    out << picture_ << " shows " << count << " of " << ids.size() << " patches\n";
  }

 private:
  std::string path_, picture_;
  bool overwrite_ = false;
  int max_ = 200;
  FilterOptions choice_{"all"};
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeShowVerb() { return std::make_unique<ShowVerb>(); }

}  // namespace orient
