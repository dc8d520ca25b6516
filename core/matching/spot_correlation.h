// Normalised cross-correlation at single places of an image, many of them for few templates.
#pragma once

#include <vector>

#include "core/raster/image.h"

namespace orient {

// Neighbouring pixels of one row that take part.
struct MaskRun {
  int row = 0, first = 0, stop = 0;
};
// Of the pixels that hold data, row by row.
std::vector<MaskRun> RunsOf(const Image& image);

// A template of which only a part may be drawn (the rest is NaN).
class SpotTemplate {
 public:
  explicit SpotTemplate(const Image& templ);

  int Width() const { return image_.width; }
  int Height() const { return image_.height; }

 private:
  friend class SpotImage;

  Image image_;
  int stride_ = 0;
  std::vector<float> padded_;  // zero where not drawn, rows lengthened to `stride_`
  std::vector<MaskRun> runs_;
  double count_ = 0, sum_ = 0, squares_ = 0;
};

// The image, with sums along its rows. `image` must outlive it.
class SpotImage {
 public:
  explicit SpotImage(const Image& image);

  // The coefficient with the template's upper-left corner at the pixel; NaN where it leaves the
  // image, less than `min_valid` of it meet data, or a side is flat.
  double Correlate(const SpotTemplate& templ, int col, int row, double min_valid) const;

 private:
  struct Sums {
    double value = 0, square = 0;
  };
  bool AllValid(const SpotTemplate& templ, int col, int row) const;
  double CorrelateValid(const SpotTemplate& templ, int col, int row, double min_valid) const;

  const Image& image_;
  std::vector<float> padded_;  // zero where there is no data; some more behind the last row
  std::vector<Sums> along_;    // of all pixels before, width + 1 a row
  std::vector<int> valid_;     // likewise; empty where all is data
};

}  // namespace orient
