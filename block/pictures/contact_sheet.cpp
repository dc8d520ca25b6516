#include "block/pictures/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/base/error.h"
#include "core/raster/picture_text.h"
#include "core/raster/raster.h"
#include "interior/marks/mark_picture.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

using Colour = std::array<unsigned char, 3>;

constexpr int kPageSide = 3600;
constexpr int kLargestTile = 96, kSmallestTile = 24;
constexpr int kFrame = 2;    // coloured border of a tile
constexpr int kGap = 8;      // between rows and columns
constexpr int kLabel = 200;  // room for name and status
constexpr int kTextHeight = 12;
constexpr Colour kUsed{46, 140, 70}, kRejected{255, 140, 0}, kMissing{200, 50, 40};
constexpr Colour kNothing{205, 205, 205}, kInk{20, 20, 20};

Colour Of(Status status) {
  return status == Status::kOk ? kUsed : status == Status::kWeak ? kRejected : kMissing;
}

Colour Of(MarkState state) {
  return state == MarkState::kUsed ? kUsed : state == MarkState::kRejected ? kRejected : kMissing;
}

// How rows are laid out on pages, the same on every page.
struct Layout {
  int marks = 0;  // tiles a row
  int tile = 0;
  int rows = 0, columns = 0;  // photos a page

  explicit Layout(const std::vector<InteriorResult>& results) {
    size_t most = 1;
    for (const InteriorResult& result : results) most = std::max(most, result.marks.size());
    marks = static_cast<int>(most);
    tile = std::clamp((kPageSide - kLabel) / marks, kSmallestTile, kLargestTile);
    const int count = static_cast<int>(results.size());
    const int most_rows = std::max(1, kPageSide / RowHeight());
    const int most_columns = std::max(1, kPageSide / ColumnWidth());
    // About square: as many columns as make the sheet no taller than wide.
    columns = static_cast<int>(std::ceil(std::sqrt(1.0 * count * RowHeight() / ColumnWidth())));
    columns = std::clamp(columns, 1, most_columns);
    rows = std::clamp((count + columns - 1) / columns, 1, most_rows);
  }
  int RowHeight() const { return std::max(tile, 2 * kTextHeight + 10) + kGap; }
  int ColumnWidth() const { return kLabel + marks * tile + 2 * kGap; }
};

class Page {
 public:
  Page(int width, int height) : width_(width), height_(height) {
    rgb_.assign(3 * static_cast<size_t>(width) * height, 255);
  }
  void Fill(int col, int row, int width, int height, const Colour& colour) {
    for (int r = row; r < row + height; ++r)
      for (int c = col; c < col + width; ++c) Set(c, r, colour);
  }
  void Text(const std::string& text, int col, int row, const Colour& colour) {
    DrawText(text, col, row, kTextHeight, colour, width_, &rgb_);
  }
  // One tile of a picture of marks (grey, 0 to 255), shrunk to `side`.
  void Draw(const Image& tile, int col, int row, int side) {
    for (int r = 0; r < side; ++r)
      for (int c = 0; c < side; ++c) {
        const float value = tile.At(std::min(c * tile.width / side, tile.width - 1),
                                    std::min(r * tile.height / side, tile.height - 1));
        if (std::isnan(value)) continue;
        const auto grey = static_cast<unsigned char>(std::clamp(value, 0.0f, 255.0f));
        Set(col + c, row + r, {grey, grey, grey});
      }
  }
  void Write(const std::string& path) const { WritePng(path, width_, height_, 3, rgb_); }

 private:
  void Set(int col, int row, const Colour& colour) {
    std::copy(colour.begin(), colour.end(),
              rgb_.begin() + 3 * (static_cast<long>(row) * width_ + col));
  }
  int width_, height_;
  std::vector<unsigned char> rgb_;
};

// An open cross at the tile's centre, where the mark was found.
void DrawCentre(int col, int row, int side, const Colour& colour, Page* page) {
  const int middle = side / 2, from = std::max(3, side / 8), to = std::max(5, side / 4);
  page->Fill(col + middle - to, row + middle, to - from, 1, colour);
  page->Fill(col + middle + from, row + middle, to - from, 1, colour);
  page->Fill(col + middle, row + middle - to, 1, to - from, colour);
  page->Fill(col + middle, row + middle + from, 1, to - from, colour);
}

// Tiles of the photo's picture of marks, one each; empty where it cannot be read.
std::vector<Image> Tiles(const std::string& path, size_t marks, int side) {
  std::vector<Image> tiles;
  std::error_code none;
  if (!fs::exists(path, none)) return tiles;
  try {
    const Raster picture = Raster::Open(path);
    const int size = picture.Height();
    const double reduction = std::max(1.0, static_cast<double>(size) / side);
    for (size_t i = 0; i < marks; ++i)
      tiles.push_back(
          picture
              .ReadGrey({static_cast<int>(i) * (size + interior::kMarkTileGap), 0, size, size},
                        reduction)
              .image);
  } catch (const InputError&) {
    tiles.clear();  // the row stays grey: a picture is no reason to end a run
  }
  return tiles;
}

std::string Shortened(const std::string& text) {
  constexpr size_t kCharacters = 20;
  if (text.size() <= kCharacters) return text;
  return text.substr(0, 8) + ".." + text.substr(text.size() - 10);
}

void DrawRow(const std::string& directory, const InteriorResult& result, const Layout& layout,
             int left, int top, Page* page) {
  page->Text(Shortened(result.photo), left, top + kTextHeight + 4, kInk);
  std::string status(Name(result.status));
  if (result.sigma0_um && std::isfinite(*result.sigma0_um))
    status += "  " + std::to_string(std::lround(*result.sigma0_um)) + " um";
  page->Text(status, left, top + 2 * kTextHeight + 8, Of(result.status));
  const std::string path = (fs::path(directory) / (result.photo + ".marks.png")).string();
  const int side = layout.tile - 2 * kFrame - 1;
  const std::vector<Image> tiles = Tiles(path, result.marks.size(), side);
  const int tile_left = left + kLabel;
  if (result.marks.empty()) page->Fill(tile_left, top, layout.tile - 1, layout.tile - 1, kNothing);
  for (size_t i = 0; i < result.marks.size(); ++i) {
    const int col = tile_left + static_cast<int>(i) * layout.tile;
    const Colour colour = Of(result.marks[i].state);
    page->Fill(col, top, layout.tile - 1, layout.tile - 1, colour);
    page->Fill(col + kFrame, top + kFrame, side, side, kNothing);
    if (i >= tiles.size()) continue;
    page->Draw(tiles[i], col + kFrame, top + kFrame, side);
    if (result.marks[i].state != MarkState::kMissing)
      DrawCentre(col + kFrame, top + kFrame, side, colour, page);
  }
}

std::string PagePath(const std::string& directory, int page) {
  const std::string number = page == 0 ? "" : "_" + std::to_string(page + 1);
  return (fs::path(directory) / ("contact_sheet" + number + ".png")).string();
}

}  // namespace

std::vector<std::string> WriteContactSheet(const std::string& directory,
                                           const std::vector<InteriorResult>& results) {
  const Layout layout(results);
  const size_t a_page = static_cast<size_t>(layout.rows) * layout.columns;
  std::vector<std::string> written;
  for (size_t first = 0; first < results.size(); first += a_page) {
    const size_t count = std::min(a_page, results.size() - first);
    const int rows = static_cast<int>(std::min(count, static_cast<size_t>(layout.rows)));
    const int columns = static_cast<int>((count + layout.rows - 1) / layout.rows);
    Page page(columns * layout.ColumnWidth() + kGap, rows * layout.RowHeight() + kGap);
    for (size_t i = 0; i < count; ++i) {
      const int column = static_cast<int>(i) / layout.rows, row = static_cast<int>(i) % layout.rows;
      DrawRow(directory, results[first + i], layout, kGap + column * layout.ColumnWidth(),
              kGap + row * layout.RowHeight(), &page);
    }
    written.push_back(PagePath(directory, static_cast<int>(written.size())));
    page.Write(written.back());
  }
  std::error_code none;
  for (int page = static_cast<int>(written.size()); fs::remove(PagePath(directory, page), none);)
    ++page;
  return written;
}

}  // namespace orient::block
