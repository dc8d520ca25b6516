#include "core/raster/window_reader.h"

#include <fcntl.h>
#include <gdal_priv.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "core/raster/reading_errors.h"

namespace orient {
namespace {

constexpr double kSmall = 4e6;  // bytes, decoded

// Whether reading any window of a band requires decoding all of it, or a large piece.
bool DecodesAll(GDALDataset* dataset, GDALRasterBand* band) {
  const std::string driver = dataset->GetDriverName();
  if (driver == "JPEG" || driver == "PNG") return true;
  int width = 0, height = 0;
  band->GetBlockSize(&width, &height);
  return dataset->GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE") != nullptr &&
         double(width) * height * GDALGetDataTypeSizeBytes(band->GetRasterDataType()) > kSmall;
}

std::FILE* NamelessFile() {
  const char* folder = std::getenv("TMPDIR");
  const int file = open(folder != nullptr && *folder != '\0' ? folder : "/var/tmp",
                        O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  return file < 0 ? nullptr : fdopen(file, "w+b");
}

template <typename Value>
void Convert(const std::vector<unsigned char>& bytes, float* values) {
  const auto* from = reinterpret_cast<const Value*>(bytes.data());
  std::copy(from, from + bytes.size() / sizeof(Value), values);
}

}  // namespace

WindowReader::WindowReader(GDALDataset* dataset, std::vector<GDALRasterBand*> bands)
    : bands_(std::move(bands)),
      width_(static_cast<std::size_t>(bands_[0]->GetXSize())),
      height_(static_cast<std::size_t>(bands_[0]->GetYSize())) {
  const GDALDataType type = bands_[0]->GetRasterDataType();
  value_bytes_ = static_cast<std::size_t>(GDALGetDataTypeSizeBytes(type));
  const bool alike = std::all_of(bands_.begin(), bands_.end(), [&](GDALRasterBand* band) {
    return band->GetRasterDataType() == type;
  });
  decodes_all_ = alike && (type == GDT_Byte || type == GDT_UInt16) &&
                 double(Place(bands_.size(), 0, 0)) > kSmall && DecodesAll(dataset, bands_[0]);
}

std::size_t WindowReader::Place(std::size_t band, int row, int col) const {
  return ((band * height_ + static_cast<std::size_t>(row)) * width_ +
          static_cast<std::size_t>(col)) *
         value_bytes_;
}

std::optional<std::string> WindowReader::Read(std::size_t band, const PixelWindow& window,
                                              float* values) {
  const int end = window.row + window.height;
  if (decodes_all_ && end < lowest_) {
    decodes_all_ = false;
    Decode();
  }
  lowest_ = std::max(lowest_, end);
  if (end <= decoded_rows_ && ReadDecoded(band, window, values)) return std::nullopt;
  return ReadWindow(bands_[band], window, values, GDT_Float32);
}

void WindowReader::Decode() {
  constexpr int kRowsAtATime = 64;
  decoded_.reset(NamelessFile());
  std::vector<unsigned char> rows;
  const int height = static_cast<int>(height_);
  while (decoded_ && decoded_rows_ < height) {
    const int count = std::min(kRowsAtATime, height - decoded_rows_);
    if (!DecodeRows(decoded_rows_, count, &rows)) return;
    decoded_rows_ += count;
  }
}

bool WindowReader::DecodeRows(int row, int count, std::vector<unsigned char>* rows) {
  rows->resize(Place(0, count, 0));
  for (std::size_t band = 0; band < bands_.size(); ++band) {
    const PixelWindow window{0, row, static_cast<int>(width_), count};
    if (ReadWindow(bands_[band], window, rows->data(), bands_[0]->GetRasterDataType()))
      return false;
    for (std::size_t done = 0; done < rows->size();) {
      const ssize_t written =
          pwrite(fileno(decoded_.get()), rows->data() + done, rows->size() - done,
                 static_cast<off_t>(Place(band, row, 0) + done));
      if (written <= 0) {  // leaves the space to other files
        decoded_rows_ = 0;
        decoded_.reset();
        return false;
      }
      done += static_cast<std::size_t>(written);
    }
  }
  return true;
}

bool WindowReader::ReadDecoded(std::size_t band, const PixelWindow& window, float* values) const {
  std::vector<unsigned char> bytes(static_cast<std::size_t>(window.width) * value_bytes_);
  for (int row = window.row; row < window.row + window.height; ++row, values += window.width) {
    const ssize_t size = pread(fileno(decoded_.get()), bytes.data(), bytes.size(),
                               static_cast<off_t>(Place(band, row, window.col)));
    if (size != static_cast<ssize_t>(bytes.size())) return false;
    if (value_bytes_ == 1)
      Convert<std::uint8_t>(bytes, values);
    else
      Convert<std::uint16_t>(bytes, values);
  }
  return true;
}

}  // namespace orient
