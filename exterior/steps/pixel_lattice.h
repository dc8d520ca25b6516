// Where the pixels of a square drawing lie in another image: computed on a lattice of nodes and
// linear between them. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "core/raster/resample.h"

namespace orient::exterior {

class PixelLattice {
 public:
  // `place` maps an offset from the drawing's corner, in the drawing's pixels, to a position in the
  // other image; empty if unknown. Nodes every `step` pixels over a square of `side`.
  PixelLattice(int side, double step,
               const std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>& place);

  // NaN next to a node whose place is unknown.
  Eigen::Vector2d At(double col, double row) const;

  // Units of the places per pixel of the drawing, along the square's sides at its middle.
  double Scale() const;

  // The middle and half the size of what the nodes cover; empty where nothing is known.
  std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> Area() const;

 private:
  const Eigen::Vector2d& Node(int col, int row) const {
    return places_[static_cast<std::size_t>(row * nodes_ + col)];
  }
  double step_;
  int nodes_;
  std::vector<Eigen::Vector2d> places_;
};

// Samples along a side of a pixel that covers `scale` pixels of the image it is drawn from.
int SamplesOfPixel(double scale, int most);

// Mean over a drawing's pixel of an image's grey values; `place(col, row)` is in image coordinates.
// NaN where any part is missing.
template <class Place>
float MeanOverPixel(const Image& image, int col, int row, int samples, const Place& place) {
  if (samples == 1) return SampleBicubic(image, place(col + 0.5, row + 0.5));
  double sum = 0;
  for (int j = 0; j < samples; ++j)
    for (int i = 0; i < samples; ++i)
      sum += SampleBilinear(image, place(col + (i + 0.5) / samples, row + (j + 0.5) / samples));
  return static_cast<float>(sum / (samples * samples));
}

}  // namespace orient::exterior
